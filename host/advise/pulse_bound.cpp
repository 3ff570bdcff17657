#include "host/advise/pulse_bound.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace stria {
namespace {

constexpr int kPhases = 8;
constexpr double kReach = 6;  ///< widths to each side; beyond, samples see only background

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }
double normal_density(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi); }

/// Derivatives of a sample's expectation by position, amplitude, width and background.
Eigen::Vector4d slopes_of(const SampledPulse& p, double x) {
    const double high = (x + p.half_aperture) / p.width, low = (x - p.half_aperture) / p.width;
    const double scale = std::sqrt(2 * std::numbers::pi) / (2 * p.half_aperture);
    const double area = normal_cdf(high) - normal_cdf(low);
    const double by_edges = normal_density(high) - normal_density(low);
    const double by_scale = high * normal_density(high) - low * normal_density(low);
    return {-p.amplitude_dn * scale * by_edges, scale * p.width * area,
            p.amplitude_dn * scale * (area - by_scale), 1};
}

/// What min(y, level) says about its mean, y normal: 1 / variance where the level is far,
/// (phi^2 / Q + P - z phi) / variance near it, z = (level - mean) / sigma. Samples are whole
/// numbers: what is drawn above full scale less a half is clipped.
double information_of(double mean, double variance, double full_scale) {
    const double z = (full_scale - 0.5 - mean) / std::sqrt(variance);
    if (z > 8) return 1 / variance;
    const double density = normal_density(z), above = normal_cdf(-z);
    const double hazard = above > 1e-300 ? density * density / above : 0;
    return std::max(0.0, hazard + 1 - above - z * density) / variance;
}

double variance_at(const SampledPulse& pulse, const SensorNoise& noise, double phase) {
    Eigen::Matrix4d fisher = Eigen::Matrix4d::Zero();
    const double reach = kReach * pulse.width + pulse.half_aperture + 2;
    for (double x = std::ceil(-reach) + phase; x < reach; x += 1) {
        const double mean = pulse.background_dn + sample_of(pulse, x);
        const Eigen::Vector4d j = slopes_of(pulse, x);
        fisher += information_of(mean, sample_variance(noise, mean), pulse.full_scale_dn) * j *
                  j.transpose();
    }
    const Eigen::Vector4d scale = fisher.diagonal().cwiseSqrt();
    if (!(scale.minCoeff() > 0)) return std::numeric_limits<double>::infinity();
    const Eigen::Vector4d inverse = scale.cwiseInverse();
    const Eigen::Matrix4d unit = inverse.asDiagonal() * fisher * inverse.asDiagonal();
    const Eigen::LLT<Eigen::Matrix4d> factor(unit);
    if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
    return factor.solve(Eigen::Vector4d::Unit(0))[0] * inverse[0] * inverse[0];
}

}  // namespace

double sample_of(const SampledPulse& p, double x) {
    const double area =
        normal_cdf((x + p.half_aperture) / p.width) - normal_cdf((x - p.half_aperture) / p.width);
    return p.amplitude_dn * p.width * std::sqrt(2 * std::numbers::pi) / (2 * p.half_aperture) *
           area;
}

double position_bound(const SampledPulse& pulse, const SensorNoise& noise) {
    double sum = 0;
    for (int i = 0; i < kPhases; ++i) sum += variance_at(pulse, noise, (i + 0.5) / kPhases);
    return std::sqrt(sum / kPhases);
}

double peak_snr(const SampledPulse& pulse, const SensorNoise& noise) {
    const double peak = sample_of(pulse, 0);
    return peak / std::sqrt(sample_variance(noise, pulse.background_dn + peak));
}

}  // namespace stria
