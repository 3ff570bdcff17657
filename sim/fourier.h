#pragma once
#include <complex>
#include <cstddef>
#include <span>

namespace stria {

/// Discrete Fourier transforms of one length, in place, neither scaled: forward then inverse gives
/// the input times the length. Eigen's kissfft; may be used from several threads.
class Fourier {
  public:
    /// Throws std::invalid_argument unless `length` is 1 to 2^24. Powers of two are fastest.
    explicit Fourier(std::size_t length);

    std::size_t length() const { return length_; }
    /// Sum over x of values[x] exp(-2 pi i f x / length).
    void forward(std::span<std::complex<double>> values) const;
    /// The same with exp(+2 pi i f x / length).
    void inverse(std::span<std::complex<double>> values) const;

  private:
    std::size_t length_ = 0;
};

}  // namespace stria
