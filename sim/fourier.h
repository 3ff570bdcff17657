#pragma once
#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace stria {

/// Discrete Fourier transforms of one length, in place, neither scaled: forward then inverse gives
/// the input times the length. Cooley and Tukey 1965, radix 2.
class Fourier {
  public:
    /// Throws std::invalid_argument unless `length` is a power of two, at most 2^24.
    explicit Fourier(std::size_t length);

    std::size_t length() const { return order_.size(); }
    /// Sum over x of values[x] exp(-2 pi i f x / length).
    void forward(std::span<std::complex<double>> values) const;
    /// The same with exp(+2 pi i f x / length).
    void inverse(std::span<std::complex<double>> values) const;

  private:
    void transform(std::span<std::complex<double>> values, double sign) const;

    std::vector<std::uint32_t> order_;         ///< bits reversed
    std::vector<std::complex<double>> roots_;  ///< exp(-2 pi i k / length), half a turn
};

}  // namespace stria
