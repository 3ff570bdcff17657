#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "firmware/core/frame.h"
#include "tests/firmware/stripe/cramer_rao.h"

namespace stria::test {

/// What a Monte Carlo cell found.
struct LocalisationCell {
    double rms = 0;          ///< of the position's error
    double bound = 0;        ///< rms of the Cramer-Rao bound over the trials
    double mean = 0;         ///< of the error
    double sigma_ratio = 0;  ///< median predicted sigma over the actual one, 1.4826 MAD
    double found = 0;        ///< share of the trials with an answer
    int trials = 0;
    double ratio() const { return rms / bound; }
};

/// Gathers single trials.
class LocalisationTally {
  public:
    void add_missing() { ++trials_; }
    void add(double error, double sigma, double bound) {
        ++trials_;
        errors_.push_back(error);
        sigmas_.push_back(sigma);
        squares_ += error * error;
        bounds_ += bound * bound;
        sum_ += error;
    }
    int trials() const { return trials_; }
    LocalisationCell cell() {
        LocalisationCell out;
        const auto n = static_cast<double>(errors_.size());
        out.trials = trials_;
        out.found = n / trials_;
        out.rms = std::sqrt(squares_ / n);
        out.bound = std::sqrt(bounds_ / n);
        out.mean = sum_ / n;
        for (double& error : errors_) error = std::abs(error);
        out.sigma_ratio = median(sigmas_) / (1.4826 * median(errors_));
        return out;
    }

  private:
    static double median(std::vector<double>& values) {
        const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::nth_element(values.begin(), middle, values.end());
        return *middle;
    }
    std::vector<double> errors_, sigmas_;
    double squares_ = 0, bounds_ = 0, sum_ = 0;
    int trials_ = 0;
};

/// A sample as the sensor gives it: shot and read noise (normal), rounded, clipped to 0..full.
inline int noisy_sample(double expected, const SensorNoise& noise, int full_scale,
                        std::mt19937_64& rng) {
    const double variance = sample_variance(noise, expected) - 1.0 / 12.0;  // rounding adds that
    std::normal_distribution<double> normal(0.0, std::sqrt(std::max(variance, 0.0)));
    const double value = expected + (variance > 0 ? normal(rng) : 0.0);
    return static_cast<int>(std::clamp(std::floor(value + 0.5), 0.0, double(full_scale)));
}

inline void set_sample(Frame& frame, int x, int y, int value) {
    const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(frame.width) +
                   static_cast<std::size_t>(x);
    if (frame.bits > 8)
        reinterpret_cast<std::uint16_t*>(frame.bytes.data())[i] = static_cast<std::uint16_t>(value);
    else
        frame.bytes[i] = static_cast<std::uint8_t>(value);
}

/// Sensor whose noise at the peak makes amplitude / noise = snr: additive noise alone, or half of
/// the peak's variance from its own light.
inline SensorNoise sensor_for(double amplitude, double snr, bool shot) {
    const double variance = amplitude * amplitude / (snr * snr) - 1.0 / 12.0;
    SensorNoise noise;
    noise.gain_e_per_dn = shot ? amplitude / (0.5 * variance) : 1e9;
    noise.read_noise_e = std::sqrt(shot ? 0.5 * variance : variance) * noise.gain_e_per_dn;
    return noise;
}

}  // namespace stria::test
