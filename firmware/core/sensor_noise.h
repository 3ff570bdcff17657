#pragma once

namespace stria {

/// What a camera's sample of digital number (DN) is worth, for weights and sigmas.
/// Variance of a sample: gain (DN - black_dn) + (read_noise_e / gain_e_per_dn)^2 + 1/12, in DN^2,
/// with gain = 1 / gain_e_per_dn (EMVA 1288 linear model).
struct SensorNoise {
    double gain_e_per_dn = 40.0;  ///< electrons per DN of the frame's own bit depth
    double read_noise_e = 10.0;   ///< standard deviation
    double black_dn = 0.0;        ///< DN of no light
};

/// Variance (DN^2) of a sample whose expectation is `signal_dn`, quantisation included.
inline double sample_variance(const SensorNoise& noise, double signal_dn) {
    const double read_dn = noise.read_noise_e / noise.gain_e_per_dn;
    const double light_dn = signal_dn > noise.black_dn ? signal_dn - noise.black_dn : 0.0;
    return light_dn / noise.gain_e_per_dn + read_dn * read_dn + 1.0 / 12.0;
}

}  // namespace stria
