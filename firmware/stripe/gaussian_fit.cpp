#include "firmware/stripe/gaussian_fit.h"

#include <algorithm>
#include <cmath>

#include "firmware/stripe/fit_search.h"
#include "firmware/stripe/gaussian_integral.h"

namespace stria {
namespace {

constexpr int kMaxIterations = 50;
// Then half ones: new weights after each step can make it hop to and fro about the solution.
constexpr int kFullSteps = 15;
constexpr double kNarrowAperture = 0.2;  // h / w below which the second order is exact to 4e-5
// Predicted decrease of the deviance by a step, in squared sigmas, after which no more are needed
// (the next step is far smaller), and with which a fit that used up its iterations is still good.
constexpr double kTightDecrease = 1e-4;
constexpr double kLooseDecrease = 1e-2;
// Or the last move of the position, in widths: of a clipped pulse height and width are hardly known
// apart and keep drifting, while the position stands.
constexpr double kLooseMove = 1e-3;
// Equal Gaussians nearer than so many widths have one maximum together: a light that a tilted
// surface broadened looks the same.
constexpr double kTwoMaxima = 2.0;
// A pulse clipped so far that few samples of its flanks are left does not tell its height from its
// width: the likelihood stays flat while the height runs away. Heights above so many full scales
// are taken to be as improbable as a normal distribution of their logarithm says (a prior that is
// flat below, so that no other pulse knows of it).
constexpr double kUsualHeight = 8.0;
constexpr double kLogHeightSpread = 1.0;

/// Weight (minus the second derivative of the log likelihood by the model value) and slope (first
/// derivative) of a saturated sample: log Q(z), z = (level - model) / s.
struct CensoredTerms {
    double slope, weight, deviance;
};

CensoredTerms censored_terms(double level, double model, double variance) {
    const double s = std::sqrt(variance);
    const double z = (level - model) / s;
    double hazard, log_tail;
    if (z > 20.0) {  // asymptotic series of the Mills ratio; erfc is about to underflow
        hazard = z + 1.0 / z;
        log_tail = -0.5 * z * z - std::log(hazard * kSqrtTwoPi);
    } else {
        const double tail = 0.5 * std::erfc(z / std::sqrt(2.0));
        hazard = std::exp(-0.5 * z * z) / kSqrtTwoPi / tail;
        log_tail = std::log(tail);
    }
    return {hazard / s, std::max(hazard * (hazard - z), 0.0) / variance, -2.0 * log_tail};
}

/// Levenberg-Marquardt over [A1, m1, (A2, m2,) log w, b].
template <int kPeaks>
class Fitter {
  public:
    static constexpr int kSize = 2 * kPeaks + 2;
    static constexpr int kLogWidth = 2 * kPeaks;
    static constexpr int kBackground = kLogWidth + 1;
    using Vector = std::array<double, kSize>;
    using Matrix = std::array<Vector, kSize>;

    Fitter(const FitSamples& samples, const SensorNoise& noise, double full_scale,
           const FitStart& limits)
        : samples_(samples), noise_(noise), saturation_level_(full_scale - 0.5) {
        const double margin = 0.5 * (samples.x[1] - samples.x[0]);
        min_position_ = samples.x[0] - margin;
        max_position_ = samples.x[static_cast<std::size_t>(samples.count - 1)] + margin;
        min_log_width_ = std::log(limits.min_width);
        max_log_width_ = std::log(limits.max_width);
        usual_amplitude_ = kUsualHeight * full_scale;
        max_amplitude_ = 100.0 * full_scale;
    }

    GaussianFit run(Vector p) {
        GaussianFit fit;
        fit.peaks = kPeaks;
        clamp(p);
        evaluate(p, current_);
        double damping = 1e-3;
        while (fit.iterations < kMaxIterations && !fit.converged) {
            ++fit.iterations;
            set_weights();
            accumulate(p);
            hold_width_at_limit(p[kLogWidth]);
            fit.converged = !improve(p, damping, fit.iterations > kFullSteps ? 0.5 : 1.0);
        }
        fit.converged = fit.converged || last_decrease_ < kLooseDecrease ||
                        last_move_ < kLooseMove * std::exp(p[kLogWidth]);
        set_weights();
        accumulate(p);
        hold_width_at_limit(p[kLogWidth]);
        report(p, fit);
        return fit;
    }

  private:
    struct Evaluation {
        std::array<double, kMaxFitSamples> model;
        std::array<std::array<double, kMaxFitSamples>, kSize - 1> slope;  // the background's is 1
    };

    void clamp(Vector& p) const {
        for (int k = 0; k < kPeaks; ++k) {
            p[2 * k] = std::clamp(p[2 * k], 1e-3, max_amplitude_);
            p[2 * k + 1] = std::clamp(p[2 * k + 1], min_position_, max_position_);
        }
        p[kLogWidth] = std::clamp(p[kLogWidth], min_log_width_, max_log_width_);
    }

    void evaluate(const Vector& p, Evaluation& out) const {
        const double width = std::exp(p[kLogWidth]);
        std::fill_n(out.model.begin(), samples_.count, p[kBackground]);
        std::fill_n(out.slope[kLogWidth].begin(), samples_.count, 0.0);
        for (int k = 0; k < kPeaks; ++k) add_peak(p[2 * k], p[2 * k + 1], width, 2 * k, out);
    }

    void add_peak(double amplitude, double position, double width, int column,
                  Evaluation& out) const {
        const double h = samples_.half_aperture;
        const bool narrow = h < kNarrowAperture * width;
        double last_edge = -1e300;
        NormalTerms last{};
        for (int i = 0; i < samples_.count; ++i) {
            const double x = samples_.x[i];
            ApertureGaussian g;
            if (std::abs(x - position) > 6.5 * width + h) {  // below 1e-9 of the height
                out.slope[column][i] = out.slope[column + 1][i] = 0;
                continue;
            }
            if (narrow) {
                g = narrow_aperture_gaussian((x - position) / width, width, h);
            } else {
                const double z_low = (x - h - position) / width;
                const double z_high = (x + h - position) / width;
                const NormalTerms low = x - h == last_edge ? last : normal_terms(z_low);
                const NormalTerms high = normal_terms(z_high);
                last_edge = x + h;
                last = high;
                g = aperture_gaussian(low, high, z_low, z_high, width, h);
            }
            out.model[i] += amplitude * g.value;
            out.slope[column][i] = g.value;
            out.slope[column + 1][i] = amplitude * g.by_position;
            out.slope[kLogWidth][i] += amplitude * g.by_log_width;
        }
    }

    /// Freezes the weights at the present model: Fisher scoring.
    void set_weights() {
        for (int i = 0; i < samples_.count; ++i)
            variance_[i] = sample_variance(noise_, current_.model[i]) *
                           (samples_.interpolated ? samples_.variance_share[i] : 1.0);
    }

    /// By how many of its standard deviations the logarithm of a height exceeds what is usual.
    double excess(double amplitude) const {
        if (amplitude <= usual_amplitude_) return 0;
        return std::log(amplitude / usual_amplitude_) / kLogHeightSpread;
    }

    double objective(const Vector& p, const Evaluation& at) const {
        double sum = 0;
        for (int i = 0; i < samples_.count; ++i) {
            if (samples_.saturated[i]) {
                sum += censored_terms(saturation_level_, at.model[i], variance_[i]).deviance;
            } else {
                const double r = samples_.y[i] - at.model[i];
                sum += r * r / variance_[i];
            }
        }
        for (int k = 0; k < kPeaks; ++k) sum += excess(p[2 * k]) * excess(p[2 * k]);
        return sum;
    }

    void accumulate(const Vector& p) {
        fisher_ = {};
        gradient_ = {};
        for (int i = 0; i < samples_.count; ++i) {
            double weight, slope;
            if (samples_.saturated[i]) {
                const CensoredTerms c =
                    censored_terms(saturation_level_, current_.model[i], variance_[i]);
                weight = c.weight;
                slope = c.slope;
            } else {
                weight = 1.0 / variance_[i];
                slope = (samples_.y[i] - current_.model[i]) * weight;
            }
            Vector j;
            for (int a = 0; a < kSize - 1; ++a) j[a] = current_.slope[a][i];
            j[kBackground] = 1.0;
            for (int a = 0; a < kSize; ++a) {
                gradient_[a] += slope * j[a];
                for (int b = 0; b <= a; ++b) fisher_[a][b] += weight * j[a] * j[b];
            }
        }
        for (int k = 0; k < kPeaks; ++k) {
            const double over = excess(p[2 * k]);
            if (over <= 0) continue;
            const double slope = 1.0 / (kLogHeightSpread * p[2 * k]);
            gradient_[2 * k] -= over * slope;
            fisher_[2 * k][2 * k] += slope * slope;
        }
    }

    /// Takes the width out of the equations where it would leave its limits.
    void hold_width_at_limit(double log_width) {
        const bool low = log_width <= min_log_width_ && gradient_[kLogWidth] < 0;
        const bool high = log_width >= max_log_width_ && gradient_[kLogWidth] > 0;
        if (!low && !high) return;
        gradient_[kLogWidth] = 0;
        for (int a = 0; a < kSize; ++a) fisher_[a][kLogWidth] = fisher_[kLogWidth][a] = 0;
        fisher_[kLogWidth][kLogWidth] = 1;
    }

    /// One accepted step, or that share of it; false when the solution is reached or no step helps
    /// any more.
    bool improve(Vector& p, double& damping, double share) {
        const double before = objective(p, current_);
        for (int attempt = 0; attempt < 8; ++attempt) {
            Matrix lower = fisher_;
            for (int a = 0; a < kSize; ++a) lower[a][a] *= 1.0 + damping;
            Vector step = gradient_;
            if (!factor(lower)) return false;
            solve(lower, step);
            double decrease = 0;  // of the deviance, predicted: in units of sigma squared
            for (int a = 0; a < kSize; ++a) decrease += step[a] * gradient_[a];
            Vector trial_p = p;
            for (int a = 0; a < kSize; ++a) trial_p[a] += share * step[a];
            trial_p[kLogWidth] = std::clamp(trial_p[kLogWidth], p[kLogWidth] - 0.7,
                                            p[kLogWidth] + 0.7);  // at most a factor of two
            clamp(trial_p);
            evaluate(trial_p, trial_);
            if (objective(trial_p, trial_) <= before + 1e-9 * std::abs(before)) {
                last_decrease_ = decrease;
                last_move_ = 0;
                for (int k = 0; k < kPeaks; ++k)
                    last_move_ = std::max(last_move_, std::abs(trial_p[2 * k + 1] - p[2 * k + 1]));
                p = trial_p;
                std::swap(current_, trial_);
                damping = std::max(damping * 0.1, 1e-9);
                return decrease > kTightDecrease;
            }
            damping = std::max(damping * 10.0, 1e-3);
        }
        return false;
    }

    /// In-place Cholesky of the lower triangle; false if not positive definite.
    static bool factor(Matrix& m) {
        for (int a = 0; a < kSize; ++a) {
            for (int b = 0; b <= a; ++b) {
                double sum = m[a][b];
                for (int k = 0; k < b; ++k) sum -= m[a][k] * m[b][k];
                if (a != b) {
                    m[a][b] = sum / m[b][b];
                } else {
                    if (!(sum > 1e-14 * m[a][a])) return false;
                    m[a][a] = std::sqrt(sum);
                }
            }
        }
        return true;
    }

    static void solve(const Matrix& lower, Vector& x) {
        for (int a = 0; a < kSize; ++a) {
            for (int k = 0; k < a; ++k) x[a] -= lower[a][k] * x[k];
            x[a] /= lower[a][a];
        }
        for (int a = kSize - 1; a >= 0; --a) {
            for (int k = a + 1; k < kSize; ++k) x[a] -= lower[k][a] * x[k];
            x[a] /= lower[a][a];
        }
    }

    /// Root of a diagonal element of the inverse Fisher matrix.
    static double sigma_of(int parameter, const Matrix& lower) {
        Vector e{};
        e[parameter] = 1.0;
        solve(lower, e);
        return std::sqrt(e[parameter]);
    }

    void report(const Vector& p, GaussianFit& fit) {
        for (int k = 0; k < kPeaks; ++k) {
            fit.amplitude[k] = p[2 * k];
            fit.position[k] = p[2 * k + 1];
        }
        fit.width = std::exp(p[kLogWidth]);
        fit.background = p[kBackground];
        fit.width_at_limit = p[kLogWidth] <= min_log_width_ || p[kLogWidth] >= max_log_width_;
        report_misfit(fit);
        Matrix lower = fisher_;
        if (!factor(lower)) {
            fit.converged = false;
            return;
        }
        for (int k = 0; k < kPeaks; ++k) {
            fit.sigma_amplitude[k] = sigma_of(2 * k, lower);
            fit.sigma[k] = sigma_of(2 * k + 1, lower);
        }
    }

    void report_misfit(GaussianFit& fit) const {
        double chi_square = 0, residual = 0;
        int used = 0;
        for (int i = 0; i < samples_.count; ++i) {
            const double v = variance_[i];
            if (samples_.saturated[i]) {
                fit.deviance += censored_terms(saturation_level_, current_.model[i], v).deviance;
                continue;
            }
            const double r = samples_.y[i] - current_.model[i];
            chi_square += r * r / v;
            residual += r * r;
            fit.deviance += std::log(v);
            ++used;
        }
        fit.deviance += chi_square;
        fit.degrees_of_freedom = std::max(used - kSize, 1);
        fit.chi_square = chi_square / fit.degrees_of_freedom;
        fit.rms_residual = std::sqrt(residual / std::max(used, 1));
    }

    const FitSamples& samples_;
    const SensorNoise& noise_;
    double saturation_level_;
    double min_position_, max_position_, min_log_width_, max_log_width_;
    double usual_amplitude_, max_amplitude_;
    Evaluation current_, trial_;
    std::array<double, kMaxFitSamples> variance_;
    Matrix fisher_;
    Vector gradient_;
    double last_decrease_ = 1e300, last_move_ = 1e300;
};

/// Sample i over the single pulse, the aperture's blur to second order.
double residual_at(const FitSamples& samples, const GaussianFit& fit, int i) {
    const double h = samples.half_aperture, w = fit.width;
    const double d = samples.x[i] - fit.position[0];
    const double g = std::exp(-0.5 * d * d / (w * w + h * h / 3.0));
    const double blur = w / std::sqrt(w * w + h * h / 3.0);
    return samples.y[i] - fit.background - fit.amplitude[0] * blur * g;
}

/// Where a second pulse would help most: the greatest residual, smoothed over three samples.
struct Residual {
    double position = 0, amplitude = 0;
};

Residual greatest_residual(const FitSamples& samples, const GaussianFit& fit) {
    Residual best;
    for (int i = 1; i + 1 < samples.count; ++i) {
        const double r = (residual_at(samples, fit, i - 1) + 2.0 * residual_at(samples, fit, i) +
                          residual_at(samples, fit, i + 1)) /
                         4.0;
        if (r > best.amplitude) best = {samples.x[i], r};
    }
    return best;
}

/// True if the samples about the pulse's middle lie below it, as of two alike seen as one.
bool is_flat_topped(const FitSamples& samples, const GaussianFit& fit) {
    double sum = 0;
    for (int i = 0; i < samples.count; ++i)
        if (std::abs(samples.x[i] - fit.position[0]) < 0.7 * fit.width)
            sum += residual_at(samples, fit, i);
    return sum < 0;
}

bool significant_misfit(const GaussianFit& fit) {
    return fit.chi_square > 1.0 + 3.0 * std::sqrt(2.0 / fit.degrees_of_freedom);
}

/// Every pulse lies inside the window, known to about its own width, and is there at all.
bool is_certain(const FitSamples& samples, const GaussianFit& fit) {
    const double half_step = 0.5 * (samples.x[1] - samples.x[0]);
    const double first = samples.x[0], last = samples.x[samples.count - 1];
    const bool clipped =
        std::count(samples.saturated.begin(), samples.saturated.begin() + samples.count, 1) > 0;
    for (int k = 0; k < fit.peaks; ++k) {
        if (fit.sigma[k] > fit.width + half_step) return false;
        // A narrow or clipped pulse may trade height against width and yet be certain.
        if (!clipped && fit.width > 3.0 * half_step &&
            fit.amplitude[k] < 3.0 * fit.sigma_amplitude[k])
            return false;
        if (fit.position[k] <= first - half_step || fit.position[k] >= last + half_step)
            return false;
    }
    return true;
}

/// True if some sample between the two pulses lies clearly below the lower one's height.
bool has_valley(const FitSamples& samples, const GaussianFit& two) {
    const double low = std::min(two.position[0], two.position[1]);
    const double high = std::max(two.position[0], two.position[1]);
    double top_low = 0, top_high = 0, valley = 1e300;
    for (int i = 0; i < samples.count; ++i) {
        const double x = samples.x[i], y = samples.y[i];
        if (std::abs(x - low) < two.width) top_low = std::max(top_low, y);
        if (std::abs(x - high) < two.width) top_high = std::max(top_high, y);
        if (x > low && x < high) valley = std::min(valley, y);
    }
    const double lower_top = std::min(top_low, top_high);
    return valley - two.background < 0.8 * (lower_top - two.background);
}

}  // namespace

GaussianFit fit_one_gaussian(const FitSamples& samples, const SensorNoise& noise, double full_scale,
                             const FitStart& start) {
    if (samples.count <= Fitter<1>::kSize) return {};
    Fitter<1> fitter(samples, noise, full_scale, start);
    return fitter.run({start.amplitude, start.position, std::log(start.width), start.background});
}

GaussianFit fit_two_gaussians(const FitSamples& samples, const SensorNoise& noise,
                              double full_scale, const GaussianFit& from, const FitStart& limits) {
    if (samples.count <= Fitter<2>::kSize) return {};
    Fitter<2> fitter(samples, noise, full_scale, limits);
    GaussianFit fit = fitter.run({from.amplitude[0], from.position[0], from.amplitude[1],
                                  from.position[1], std::log(from.width), from.background});
    if (fit.amplitude[1] > fit.amplitude[0]) {
        std::swap(fit.amplitude[0], fit.amplitude[1]);
        std::swap(fit.position[0], fit.position[1]);
        std::swap(fit.sigma[0], fit.sigma[1]);
    }
    return fit;
}

namespace {

/// Started at the single pulse and what it leaves over: a strong pulse and a weak one. Where that
/// does not explain the samples, also at its two flanks: two alike, whose single fit is a wide one
/// in the middle.
GaussianFit best_two(const FitSamples& samples, const SensorNoise& noise, double full_scale,
                     const GaussianFit& one, const Residual& residual, const FitStart& limits) {
    GaussianFit from = one;
    from.position[1] = residual.position;
    from.amplitude[1] = residual.amplitude;
    const GaussianFit unequal = fit_two_gaussians(samples, noise, full_scale, from, limits);
    if (unequal.converged && !significant_misfit(unequal)) return unequal;
    if (!is_flat_topped(samples, one)) return unequal;

    from.width = 0.6 * one.width;
    from.position = {one.position[0] - 0.8 * one.width, one.position[0] + 0.8 * one.width};
    from.amplitude = {one.amplitude[0], one.amplitude[0]};
    const GaussianFit alike = fit_two_gaussians(samples, noise, full_scale, from, limits);
    if (!unequal.converged) return alike;
    return alike.converged && alike.deviance < unequal.deviance ? alike : unequal;
}

/// The single pulse from `start`; where that leaves a doubt (no certain pulse, a significant
/// misfit, a width at its limit), the more likely one of it and of what a search begins with.
GaussianFit best_one(const FitSamples& samples, const SensorNoise& noise, double full_scale,
                     const FitStart& start) {
    GaussianFit one = fit_one_gaussian(samples, noise, full_scale, start);
    one.converged = one.converged && is_certain(samples, one);
    if (!start.search || (one.converged && !one.width_at_limit && !significant_misfit(one)))
        return one;
    const auto searched = search_start(samples, noise, full_scale, start);
    if (!searched) return one;
    const GaussianFit other = fit_one_gaussian(samples, noise, full_scale, *searched);
    if (!other.converged || !is_certain(samples, other)) return one;
    return !one.converged || other.deviance < one.deviance ? other : one;
}

}  // namespace

GaussianFit fit_pulses(const FitSamples& samples, const SensorNoise& noise, double full_scale,
                       const FitStart& start, double min_amplitude) {
    GaussianFit one = best_one(samples, noise, full_scale, start);
    if (!one.converged || !significant_misfit(one)) return one;
    const Residual residual = greatest_residual(samples, one);
    if (residual.amplitude < 0.5 * min_amplitude) return one;

    const GaussianFit two = best_two(samples, noise, full_scale, one, residual, start);
    if (!two.converged || two.width_at_limit || !is_certain(samples, two)) return one;
    const double separation = std::abs(two.position[0] - two.position[1]);
    const double smallest = std::max(min_amplitude, 0.05 * two.amplitude[0]);
    if (separation < two.width || two.amplitude[1] < smallest) return one;
    // A flat-topped profile is also better described by two Gaussians: where even those do not
    // explain the samples, two pulses need a valley between them.
    if (significant_misfit(two) && !has_valley(samples, two)) return one;
    const double scale = std::max(two.chi_square, 1.0);
    const double penalty = 2.0 * std::log(static_cast<double>(samples.count));  // 2 parameters
    if ((one.deviance - two.deviance) / scale <= penalty) return one;
    if (separation >= kTwoMaxima * two.width) return two;
    one.unresolved = true;
    return one;
}

double sampled_amplitude(const GaussianFit& fit, int k, double half_aperture) {
    const double w2 = fit.width * fit.width;  // a box of half length h adds h^2 / 3
    return fit.amplitude[k] * fit.width / std::sqrt(w2 + half_aperture * half_aperture / 3.0);
}

double sigma_inflation(const GaussianFit& fit) {
    return significant_misfit(fit) ? std::sqrt(fit.chi_square) : 1.0;
}

}  // namespace stria
