#include "firmware/stripe/gaussian_fit.h"

#include <algorithm>
#include <cmath>

#include "firmware/stripe/gaussian_integral.h"

namespace stria {
namespace {

constexpr int kMaxIterations = 80;
// Then half ones for a single pulse over time, which new weights after each step can make hop to
// and fro about its solution. One that stands for two goes a long way by small steps.
constexpr int kFullSteps = 15;
constexpr double kNarrowAperture = 0.2;  // h / w below which the second order is exact to 4e-5
// Predicted decrease of the deviance by a step, in squared sigmas, after which no more are needed
// (the next step is far smaller), and with which a fit that used up its iterations is still good.
constexpr double kTightDecrease = 1e-4;
constexpr double kLooseDecrease = 1e-2;
// Or the last move of the position, in widths: of a clipped pulse height and width are hardly known
// apart and keep drifting, while the position stands.
constexpr double kLooseMove = 1e-3;
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

/// Levenberg-Marquardt over [A1, m1, (A2, m2,) log w1, (log w2,) b].
template <int kPeaks, int kWidths = 1>
class Fitter {
  public:
    static constexpr int kSize = 2 * kPeaks + kWidths + 1;
    static constexpr int kLogWidth = 2 * kPeaks;
    static constexpr int kBackground = kLogWidth + kWidths;
    /// Index of the logarithm of peak k's width.
    static constexpr int log_width_of(int k) { return kLogWidth + std::min(k, kWidths - 1); }
    using Vector = std::array<double, kSize>;
    using Matrix = std::array<Vector, kSize>;

    Fitter(const FitSamples& samples, const SensorNoise& noise, double full_scale,
           const FitStart& limits)
        : samples_(samples),
          noise_(noise),
          search_(limits.search),
          saturation_level_(full_scale - 0.5) {
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
            hold_widths_at_limit(p);
            fit.converged = !improve(
                p, damping, kPeaks == 1 && search_ && fit.iterations > kFullSteps ? 0.5 : 1.0);
        }
        fit.converged = fit.converged || last_decrease_ < kLooseDecrease ||
                        last_move_ < kLooseMove * std::exp(p[kLogWidth]);
        set_weights();
        accumulate(p);
        hold_widths_at_limit(p);
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
        for (int a = kLogWidth; a < kBackground; ++a)
            p[a] = std::clamp(p[a], min_log_width_, max_log_width_);
    }

    void evaluate(const Vector& p, Evaluation& out) const {
        std::fill_n(out.model.begin(), samples_.count, p[kBackground]);
        for (int a = kLogWidth; a < kBackground; ++a)
            std::fill_n(out.slope[a].begin(), samples_.count, 0.0);
        for (int k = 0; k < kPeaks; ++k) add_peak(k, p, out);
    }

    void add_peak(int k, const Vector& p, Evaluation& out) const {
        const double amplitude = p[2 * k], position = p[2 * k + 1];
        const double width = std::exp(p[log_width_of(k)]);
        const int column = 2 * k;
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
            out.slope[log_width_of(k)][i] += amplitude * g.by_log_width;
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

    /// Takes widths out of the equations where they would leave their limits.
    void hold_widths_at_limit(const Vector& p) {
        for (int w = kLogWidth; w < kBackground; ++w) {
            const bool low = p[w] <= min_log_width_ && gradient_[w] < 0;
            const bool high = p[w] >= max_log_width_ && gradient_[w] > 0;
            if (!low && !high) continue;
            gradient_[w] = 0;
            for (int a = 0; a < kSize; ++a) fisher_[a][w] = fisher_[w][a] = 0;
            fisher_[w][w] = 1;
        }
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
            for (int w = kLogWidth; w < kBackground; ++w)  // at most a factor of two
                trial_p[w] = std::clamp(trial_p[w], p[w] - 0.7, p[w] + 0.7);
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
        fit.second_width = std::exp(p[kBackground - 1]);
        fit.background = p[kBackground];
        for (int w = kLogWidth; w < kBackground; ++w)
            fit.width_at_limit |= p[w] <= min_log_width_ || p[w] >= max_log_width_;
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
    bool search_;
    double saturation_level_;
    double min_position_, max_position_, min_log_width_, max_log_width_;
    double usual_amplitude_, max_amplitude_;
    Evaluation current_, trial_;
    std::array<double, kMaxFitSamples> variance_;
    Matrix fisher_;
    Vector gradient_;
    double last_decrease_ = 1e300, last_move_ = 1e300;
};

void put_stronger_first(GaussianFit& fit) {
    if (fit.amplitude[1] <= fit.amplitude[0]) return;
    std::swap(fit.amplitude[0], fit.amplitude[1]);
    std::swap(fit.position[0], fit.position[1]);
    std::swap(fit.sigma[0], fit.sigma[1]);
    std::swap(fit.sigma_amplitude[0], fit.sigma_amplitude[1]);
    std::swap(fit.width, fit.second_width);
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
    put_stronger_first(fit);
    return fit;
}

GaussianFit fit_unlike_gaussians(const FitSamples& samples, const SensorNoise& noise,
                                 double full_scale, const GaussianFit& from,
                                 const FitStart& limits) {
    using Unlike = Fitter<2, 2>;
    if (samples.count <= Unlike::kSize) return {};
    GaussianFit best;
    for (int broad = 0; broad < 2; ++broad) {
        Unlike fitter(samples, noise, full_scale, limits);
        Unlike::Vector start = {from.amplitude[0], from.position[0], from.amplitude[1],
                                from.position[1]};
        start[Unlike::log_width_of(broad)] = std::log(2.0 * from.width);
        start[Unlike::log_width_of(1 - broad)] = std::log(0.9 * from.width);
        start[Unlike::kBackground] = from.background;
        const GaussianFit fit = fitter.run(start);
        if (fit.converged && (!best.converged || fit.deviance < best.deviance)) best = fit;
    }
    put_stronger_first(best);
    return best;
}

}  // namespace stria
