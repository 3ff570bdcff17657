#include "sim/fourier.h"

#include <stdexcept>
#include <string>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace stria {
namespace {

using Complex = std::complex<double>;

/// Keeps its tables from call to call; not to be shared, so each thread has its own.
Eigen::FFT<double>& engine() {
    thread_local Eigen::FFT<double> fft({}, Eigen::FFT<double>::Unscaled);
    return fft;
}

/// The values where the transform reads them: it cannot work in place.
std::span<const Complex> copied(std::span<const Complex> values, std::size_t length) {
    if (values.size() != length)
        throw std::invalid_argument("Fourier: " + std::to_string(values.size()) +
                                    " values: expected " + std::to_string(length));
    thread_local std::vector<Complex> input;
    input.assign(values.begin(), values.end());
    return input;
}

}  // namespace

Fourier::Fourier(std::size_t length) : length_(length) {
    if (length < 1 || length > (std::size_t{1} << 24))
        throw std::invalid_argument("Fourier: length = " + std::to_string(length) +
                                    ": expected 1 to 2^24");
}

void Fourier::forward(std::span<Complex> values) const {
    if (length_ == 1) return;  // kissfft has no plan for it
    engine().fwd(values.data(), copied(values, length_).data(), static_cast<Eigen::Index>(length_));
}

void Fourier::inverse(std::span<Complex> values) const {
    if (length_ == 1) return;
    engine().inv(values.data(), copied(values, length_).data(), static_cast<Eigen::Index>(length_));
}

}  // namespace stria
