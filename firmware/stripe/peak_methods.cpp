#include "firmware/stripe/peak_methods.h"

#include <algorithm>
#include <cmath>

#include "firmware/stripe/gaussian_integral.h"
#include "firmware/stripe/peak_window.h"

namespace stria {
namespace {

/// A place relative to the window's centre, and its derivative by every sample.
struct Answer {
    double offset = 0;
    std::array<double, 2 * kMaxWindowHalf + 1> slope{};
};

double& slope_at(Answer& answer, const PeakWindow& window, int t) {
    return answer.slope[static_cast<std::size_t>(t + window.half)];
}

std::optional<Answer> centre_of_gravity(const PeakWindow& window) {
    const int reach = std::max(2, static_cast<int>(std::lround(3.0 * window.blurred_width)));
    double sum = 0, moment = 0;
    for (int t = -reach; t <= reach; ++t) {
        sum += window.at(t);
        moment += t * window.at(t);
    }
    if (sum <= 0) return std::nullopt;
    Answer answer;
    answer.offset = moment / sum;
    if (std::abs(answer.offset) > reach) return std::nullopt;
    for (int t = -reach; t <= reach; ++t) slope_at(answer, window, t) = (t - answer.offset) / sum;
    return answer;
}

/// Inverse of a symmetric 3 x 3 matrix of moments (sum t^0 .. sum t^4), its last two rows.
struct ParabolaRows {
    std::array<double, 3> slope, bend;
};

std::optional<ParabolaRows> invert(const std::array<double, 5>& m) {
    const double c00 = m[2] * m[4] - m[3] * m[3];
    const double c01 = m[2] * m[3] - m[1] * m[4];
    const double c02 = m[1] * m[3] - m[2] * m[2];
    const double det = m[0] * c00 + m[1] * c01 + m[2] * c02;
    if (!(det > 1e-12 * m[0] * m[2] * m[4])) return std::nullopt;
    const double c11 = m[0] * m[4] - m[2] * m[2];
    const double c12 = m[1] * m[2] - m[0] * m[3];
    const double c22 = m[0] * m[2] - m[1] * m[1];
    return ParabolaRows{{c01 / det, c11 / det, c12 / det}, {c02 / det, c12 / det, c22 / det}};
}

/// Samples within 15 % of the height; where the top is clipped, two more on each flank.
int log_parabola_reach(const PeakWindow& window) {
    int reach = std::max(1, static_cast<int>(1.95 * window.blurred_width));
    const int most = static_cast<int>(4.0 * window.blurred_width);
    const auto flank_clipped = [&](int side) {
        return window.saturated(side * reach) || window.saturated(side * (reach - 1));
    };
    const bool clipped = window.saturated(-1) || window.saturated(0) || window.saturated(1);
    while (clipped && reach < most && (flank_clipped(-1) || flank_clipped(1))) ++reach;
    return reach;
}

std::optional<Answer> log_parabola(const PeakWindow& window) {
    const int reach = log_parabola_reach(window);
    const auto level = [&](int t) {  // the logarithm needs light: half the noise at least
        return std::max(window.at(t), 0.5 * std::sqrt(window.variance(t)));
    };
    std::array<double, 5> moments{};  // of the weights
    int used = 0;
    for (int t = -reach; t <= reach; ++t) {
        if (window.saturated(t)) continue;
        double term = level(t) * level(t);
        for (double& moment : moments) {
            moment += term;
            term *= t;
        }
        ++used;
    }
    if (used < 3) return std::nullopt;
    const auto rows = invert(moments);
    if (!rows) return std::nullopt;
    const auto weight_in = [&](const std::array<double, 3>& row, int t) {
        return level(t) * level(t) * (row[0] + t * (row[1] + t * row[2]));
    };
    double slope = 0, bend = 0;
    for (int t = -reach; t <= reach; ++t) {
        if (window.saturated(t)) continue;
        slope += weight_in(rows->slope, t) * std::log(level(t));
        bend += weight_in(rows->bend, t) * std::log(level(t));
    }
    if (!(bend < 0)) return std::nullopt;
    Answer answer;
    answer.offset = -0.5 * slope / bend;
    if (std::abs(answer.offset) > reach) return std::nullopt;
    for (int t = -reach; t <= reach; ++t) {  // that the weights vary too, is of second order
        if (window.saturated(t)) continue;
        const double by_log =
            -(0.5 * weight_in(rows->slope, t) + answer.offset * weight_in(rows->bend, t)) / bend;
        slope_at(answer, window, t) = by_log / level(t);
    }
    return answer;
}

constexpr int kBlaisRiouxArm = 4;  // order 8

double blais_rioux_filter(const PeakWindow& window, int t) {
    double sum = 0;
    for (int k = 1; k <= kBlaisRiouxArm; ++k) sum += window.at(t - k) - window.at(t + k);
    return sum;
}

std::optional<Answer> blais_rioux(const PeakWindow& window) {
    const int reach =
        std::min(window.half - kBlaisRiouxArm - 1, 1 + static_cast<int>(window.blurred_width));
    std::optional<int> nearest;  // t below the crossing
    for (int t = -reach - 1; t <= reach; ++t) {
        if (blais_rioux_filter(window, t) > 0 || blais_rioux_filter(window, t + 1) <= 0) continue;
        if (!nearest || std::abs(t + 0.5) < std::abs(*nearest + 0.5)) nearest = t;
    }
    if (!nearest) return std::nullopt;
    const double below = blais_rioux_filter(window, *nearest);
    const double above = blais_rioux_filter(window, *nearest + 1);
    const double rise = above - below;
    Answer answer;
    answer.offset = *nearest - below / rise;
    for (int k = 1; k <= kBlaisRiouxArm; ++k) {
        for (const int side : {-1, 1}) {
            const double sign = side < 0 ? 1.0 : -1.0;
            slope_at(answer, window, *nearest + side * k) -= sign * above / (rise * rise);
            slope_at(answer, window, *nearest + 1 + side * k) += sign * below / (rise * rise);
        }
    }
    return answer;
}

/// Derivative by x of log(sum I m(x) / sqrt(sum m(x)^2)) x sum I m, m the pixel-integrated Gaussian
/// at x; its own derivatives by x and by the samples.
struct Correlation {
    double value = 0, by_offset = 0;
    std::array<double, 2 * kMaxWindowHalf + 1> by_sample;
};

Correlation correlate(const PeakWindow& window, double x) {
    const double w = window.width;
    const auto count = static_cast<std::size_t>(2 * window.half + 1);
    std::array<double, 2 * kMaxWindowHalf + 1> m, m1;
    double im = 0, im1 = 0, im2 = 0, mm = 0, mm1 = 0, by_mm1 = 0;
    double z_low = (-window.half - 0.5 - x) / w;
    NormalTerms low = normal_terms(z_low);
    for (std::size_t i = 0; i < count; ++i) {
        const double z_high = z_low + 1.0 / w;
        const NormalTerms high = normal_terms(z_high);
        const double m2 = (z_low * low.density - z_high * high.density) / (kSqrtTwoPi * w * w);
        m[i] = high.cumulative - low.cumulative;
        m1[i] = (low.density - high.density) / (kSqrtTwoPi * w);
        im += window.samples[i] * m[i];
        im1 += window.samples[i] * m1[i];
        im2 += window.samples[i] * m2;
        mm += m[i] * m[i];
        mm1 += m[i] * m1[i];
        by_mm1 += m1[i] * m1[i] + m[i] * m2;
        z_low = z_high;
        low = high;
    }
    const double r = mm1 / mm, by_r = by_mm1 / mm - 2 * r * r;
    Correlation out;
    out.value = im1 - im * r;
    out.by_offset = im2 - im1 * r - im * by_r;
    for (std::size_t i = 0; i < count; ++i) out.by_sample[i] = m1[i] - m[i] * r;
    return out;
}

std::optional<Answer> matched_fir(const PeakWindow& window) {
    double low = -std::max(1.0, window.blurred_width), high = -low;
    if (correlate(window, low).value <= 0 || correlate(window, high).value >= 0)
        return std::nullopt;
    Answer answer;
    for (int step = 0; step < 20; ++step) {  // Newton's method, kept between low and high
        const Correlation c = correlate(window, answer.offset);
        (c.value > 0 ? low : high) = answer.offset;
        double next = answer.offset - c.value / c.by_offset;
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        const double move = std::abs(next - answer.offset);
        answer.offset = next;
        if (move > 1e-4 * window.width) continue;  // px; the next one would be its square
        for (std::size_t i = 0; i < c.by_sample.size(); ++i)
            answer.slope[i] = -c.by_sample[i] / c.by_offset;
        return c.by_offset < 0 ? std::optional(answer) : std::nullopt;
    }
    return std::nullopt;
}

/// The row smoothed with a Gaussian, as its Taylor polynomial at pixel p sees it.
struct Taylor {
    double first = 0, second = 0;  ///< both times the same factor
};

std::optional<Answer> steger(const PeakWindow& window) {
    const double s2 = window.blurred_width * window.blurred_width;
    const auto kernel = [&](int d) { return std::exp(-0.5 * d * d / s2); };
    const auto bend = [&](int d) { return (d * d / s2 - 1.0) * kernel(d); };
    const auto taylor = [&](int p) {
        Taylor out;
        for (int t = -window.half; t <= window.half; ++t) {
            out.first += window.at(t) * (t - p) * kernel(t - p);
            out.second += window.at(t) * bend(t - p);
        }
        return out;
    };
    const int reach = 1 + static_cast<int>(0.5 * window.blurred_width);
    std::optional<int> best;
    double least = 1.0;  // a wider step would leave the pixel's neighbours
    Taylor at_best;
    for (int p = -reach; p <= reach; ++p) {
        const Taylor here = taylor(p);
        if (here.second >= 0 || std::abs(here.first) > least * -here.second) continue;
        least = std::abs(here.first / here.second);
        best = p;
        at_best = here;
    }
    if (!best) return std::nullopt;
    const double step = -at_best.first / at_best.second;
    Answer answer;
    answer.offset = *best + step;
    for (int t = -window.half; t <= window.half; ++t) {
        const int d = t - *best;
        slope_at(answer, window, t) = -(d * kernel(d) + step * bend(d)) / at_best.second;
    }
    return answer;
}

std::optional<Answer> answer_of(PeakMethod method, const PeakWindow& window) {
    switch (method) {
        case PeakMethod::centre_of_gravity:
            return centre_of_gravity(window);
        case PeakMethod::log_parabola:
            return log_parabola(window);
        case PeakMethod::blais_rioux:
            return blais_rioux(window);
        case PeakMethod::matched_fir:
            return matched_fir(window);
        case PeakMethod::steger:
            return steger(window);
        case PeakMethod::maximum_likelihood:
            break;
    }
    return std::nullopt;
}

/// Standard deviation of the answer: the samples' noise and that of the background taken from all.
double sigma_of(const Answer& answer, const PeakWindow& window) {
    double variance = 0, sum = 0;
    for (int t = -window.half; t <= window.half; ++t) {
        const double slope = answer.slope[static_cast<std::size_t>(t + window.half)];
        variance += slope * slope * window.variance(t);
        sum += slope;
    }
    return std::sqrt(variance + sum * sum * window.background_variance);
}

constexpr std::array<std::string_view, kPeakMethods.size()> kNames = {
    "ml", "cog", "log-parabola", "blais-rioux", "fir", "steger"};

}  // namespace

std::string_view name_of(PeakMethod method) { return kNames[static_cast<std::size_t>(method)]; }

std::optional<PeakMethod> peak_method_from(std::string_view name) {
    for (const PeakMethod method : kPeakMethods)
        if (name_of(method) == name) return method;
    return std::nullopt;
}

std::optional<PlacedPeak> place_peak(PeakMethod method, std::span<const float> row,
                                     const SensorNoise& noise, double full_scale,
                                     const GaussianFit& fit, int k) {
    const double inflation = sigma_inflation(fit);
    if (method == PeakMethod::maximum_likelihood)
        return PlacedPeak{fit.position[k], fit.sigma[k] * inflation};
    const auto window = peak_window(row, noise, full_scale, fit, k);
    if (!window) return std::nullopt;
    const auto answer = answer_of(method, *window);
    if (!answer) return std::nullopt;
    const double sigma = sigma_of(*answer, *window) * inflation;
    if (!(sigma > 0) || !std::isfinite(sigma)) return std::nullopt;  // hangs on clipped samples
    return PlacedPeak{window->centre + answer->offset, sigma};
}

}  // namespace stria
