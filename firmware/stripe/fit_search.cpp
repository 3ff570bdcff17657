#include "firmware/stripe/fit_search.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace stria {
namespace {

constexpr double kWidthFactor = 1.4, kPlaceStep = 0.5;
constexpr double kReach = 4.5;  // widths from the middle beyond which a pulse is dark

/// The weighted samples, and what of the sums does not depend on place and width.
class Search {
  public:
    Search(const FitSamples& samples, const SensorNoise& noise, double full_scale)
        : samples_(samples), full_scale_(full_scale) {
        for (int i = 0; i < samples.count; ++i) {
            const double share = samples.interpolated ? samples.variance_share[i] : 1.0;
            weight_[i] = 1.0 / (sample_variance(noise, samples.y[i]) * share);
            if (samples.saturated[i]) continue;
            sum_ += weight_[i];
            sum_y_ += weight_[i] * samples.y[i];
        }
    }

    /// Tries a pulse of that place and width; keeps it if it is the best so far.
    void attempt(double position, double width) {
        const double h = samples_.half_aperture;
        const double exposed = std::sqrt(width * width + h * h / 3.0);
        double g1 = 0, gg = 0, gy = 0;
        for (int i = 0; i < samples_.count; ++i) {
            const double z = (samples_.x[i] - position) / exposed;
            shape_[i] = std::abs(z) < kReach ? std::exp(-0.5 * z * z) : 0.0;
            if (samples_.saturated[i] || shape_[i] == 0.0) continue;
            g1 += weight_[i] * shape_[i];
            gg += weight_[i] * shape_[i] * shape_[i];
            gy += weight_[i] * shape_[i] * samples_.y[i];
        }
        const double determinant = gg * sum_ - g1 * g1;
        if (!(determinant > 1e-9 * gg * sum_)) return;
        const double height = (gy * sum_ - g1 * sum_y_) / determinant;
        const double level = (sum_y_ - g1 * height) / sum_;
        if (!(height > 1e-6)) return;  // DN: rounding
        const double misfit = misfit_of(height, level);
        if (best_ && misfit >= least_) return;
        least_ = misfit;
        best_ = FitStart{.position = position,
                         .amplitude = height * exposed / width,
                         .width = width,
                         .background = level};
    }

    const std::optional<FitStart>& best() const { return best_; }

  private:
    double misfit_of(double height, double level) const {
        double sum = 0;
        for (int i = 0; i < samples_.count; ++i) {
            const double model = level + height * shape_[i];
            const double r =
                samples_.saturated[i] ? std::max(full_scale_ - model, 0.0) : samples_.y[i] - model;
            sum += weight_[i] * r * r;
        }
        return sum;
    }

    const FitSamples& samples_;
    const double full_scale_;
    std::array<double, kMaxFitSamples> weight_, shape_;
    double sum_ = 0, sum_y_ = 0;
    double least_ = 0;
    std::optional<FitStart> best_;
};

}  // namespace

std::optional<FitStart> search_start(const FitSamples& samples, const SensorNoise& noise,
                                     double full_scale, const FitStart& limits) {
    if (samples.count < 2) return std::nullopt;
    Search search(samples, noise, full_scale);
    const double first = samples.x[0], last = samples.x[samples.count - 1];
    const double widest = std::min(limits.max_width, 0.5 * (last - first));
    for (double width = limits.min_width; width <= widest; width *= kWidthFactor)
        for (double x = first; x <= last; x += kPlaceStep * width) search.attempt(x, width);
    std::optional<FitStart> best = search.best();
    if (best) {
        best->min_width = limits.min_width;
        best->max_width = limits.max_width;
        best->search = limits.search;
    }
    return best;
}

}  // namespace stria
