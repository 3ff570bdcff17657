#include "sim/fourier.h"

#include <bit>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace stria {

Fourier::Fourier(std::size_t length) {
    if (!std::has_single_bit(length) || length > (std::size_t{1} << 24))
        throw std::invalid_argument("Fourier: length = " + std::to_string(length) +
                                    ": expected a power of two, at most 2^24");
    order_.resize(length);
    for (std::size_t i = 1, j = 0; i < length; ++i) {
        std::size_t bit = length / 2;
        for (; j & bit; bit /= 2) j ^= bit;
        j ^= bit;
        order_[i] = static_cast<std::uint32_t>(j);
    }
    roots_.resize(length / 2);
    for (std::size_t k = 0; k < roots_.size(); ++k)
        roots_[k] = std::polar(
            1.0, -2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(length));
}

void Fourier::forward(std::span<std::complex<double>> values) const { transform(values, 1); }
void Fourier::inverse(std::span<std::complex<double>> values) const { transform(values, -1); }

void Fourier::transform(std::span<std::complex<double>> values, double sign) const {
    const std::size_t n = length();
    if (values.size() != n)
        throw std::invalid_argument("Fourier: " + std::to_string(values.size()) +
                                    " values: expected " + std::to_string(n));
    for (std::size_t i = 0; i < n; ++i)
        if (order_[i] > i) std::swap(values[i], values[order_[i]]);
    for (std::size_t half = 1; half < n; half *= 2) {
        const std::size_t stride = n / (2 * half);
        for (std::size_t begin = 0; begin < n; begin += 2 * half)
            for (std::size_t k = 0; k < half; ++k) {
                // Written out: std::complex's product looks for infinities.
                const std::complex<double> root = roots_[k * stride];
                const double c = root.real(), s = sign * root.imag();
                std::complex<double>&a = values[begin + k], &b = values[begin + k + half];
                const double re = b.real() * c - b.imag() * s, im = b.real() * s + b.imag() * c;
                b = {a.real() - re, a.imag() - im};
                a = {a.real() + re, a.imag() + im};
            }
    }
}

}  // namespace stria
