#include "tests/firmware/stripe/reflectance_card.h"

#include <algorithm>
#include <cmath>

#include "firmware/stripe/spacetime.h"
#include "firmware/stripe/spatial.h"
#include "tests/firmware/stripe/localisation.h"

namespace stria::test {
namespace {

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }
double normal_pdf(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2.0 * M_PI); }

/// What a real sensor of that height would have; the samples themselves are noise-free.
SensorNoise stated_noise() { return sensor_for(ReflectanceCard::kHeight, 200, false); }

double spatial_moment(const ReflectanceCard& card) {
    double worst = 0;
    for (int k = 0; k < card.frames(); ++k) {
        const double beam = card.beam_at(k);
        for (int y = 0; y < ReflectanceCard::kRows; ++y) {
            double sum = 0, moment = 0;
            for (int x = 0; x < card.width(); ++x) {
                const double light = card.light(x, beam, card.edge(y));
                sum += light;
                moment += (x - beam) * light;
            }
            worst = std::max(worst, std::abs(moment / sum));
        }
    }
    return worst;
}

/// True for pixels whose footprint the edge touches: elsewhere there is nothing to err by.
bool is_near_edge(const ReflectanceCard& card, int x, int y) {
    return std::abs(x - card.edge(y)) < 5 * std::max(card.footprint, card.box);
}

double spacetime_moment(const ReflectanceCard& card) {
    double worst = 0;
    for (int y = 0; y < ReflectanceCard::kRows; ++y) {
        for (int x = 0; x < card.width(); ++x) {
            if (!is_near_edge(card, x, y)) continue;
            double sum = 0, moment = 0;
            for (int k = 0; k < card.frames(); ++k) {
                const double light = card.light(x, card.beam_at(k), card.edge(y));
                sum += light;
                moment += (card.beam_at(k) - x) * light;
            }
            worst = std::max(worst, std::abs(moment / sum));
        }
    }
    return worst;
}

double spatial_error(const ReflectanceCard& card, const std::vector<Frame>& frames,
                     PeakMethod method) {
    double worst = 0;
    for (std::size_t k = 0; k < frames.size(); ++k) {
        const SpatialOptions options{.max_peaks_per_row = 1, .max_misfit = 1, .method = method};
        for (const Pulse& p : find_peaks(frames[k], stated_noise(), options))
            worst = std::max(worst, std::abs(p.u - card.beam_at(static_cast<double>(k))));
    }
    return worst;
}

}  // namespace

int ReflectanceCard::width() const { return 2 * static_cast<int>(std::ceil(10 * beam_width)); }

int ReflectanceCard::frames() const {
    return 1 + 2 * static_cast<int>(std::ceil(7 * beam_width / beam_step));
}

double ReflectanceCard::beam_at(double frame) const {
    return 0.5 * width() + (frame - 0.5 * (frames() - 1)) * beam_step;
}

double ReflectanceCard::beam_at_time(TimeNs t_ns) const {
    const TimeNs middle = kPeriodNs / 20;  // of the exposure
    return beam_at(static_cast<double>(t_ns - middle) / static_cast<double>(kPeriodNs));
}

double ReflectanceCard::light(double x, double x_beam, double edge) const {
    const auto beam_left_of = [&](double at) { return normal_cdf((at - x_beam) / beam_width); };
    if (box > 0) {
        const double low = x - 0.5 * box, high = x + 0.5 * box;
        const double bright = beam_left_of(std::clamp(edge, low, high)) - beam_left_of(low);
        const double all = beam_left_of(high) - beam_left_of(low);
        return (bright + (all - bright) / contrast) * std::sqrt(2 * M_PI) * beam_width / box;
    }
    // The product of beam and footprint is a Gaussian between the two.
    const double total = std::hypot(beam_width, footprint);
    const double narrow = beam_width * footprint / total;
    const double middle =
        (x * beam_width * beam_width + x_beam * footprint * footprint) / (total * total);
    const double bright = normal_cdf((edge - middle) / narrow);
    const double z = (x - x_beam) / total;
    return (bright + (1 - bright) / contrast) * std::exp(-0.5 * z * z);
}

Frame ReflectanceCard::frame(int k) const {
    Frame out;
    resize(out, width(), kRows, 16);
    out.sequence = static_cast<std::uint32_t>(k);
    out.exposure_start_ns = k * kPeriodNs;
    out.exposure_ns = kPeriodNs / 10;
    for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < width(); ++x)
            set_sample(out, x, y,
                       static_cast<int>(std::lround(kHeight * light(x, beam_at(k), edge(y)))));
    return out;
}

double greatest_shift(double contrast) {
    double worst = 0;
    for (double d = -4; d <= 4; d += 0.001) {
        const double left = normal_cdf(d);
        worst =
            std::max(worst, (1 - 1 / contrast) * normal_pdf(d) / (left + (1 - left) / contrast));
    }
    return worst;
}

void measure_spacetime(const ReflectanceCard& card, const std::vector<Frame>& frames,
                       const SensorNoise& noise, CardErrors& errors) {
    SpacetimeAnalyser analyser(card.width(), ReflectanceCard::kRows, 16, noise);
    for (const Frame& frame : frames) analyser.add(frame);
    for (int y = 0; y < ReflectanceCard::kRows; ++y)
        for (int x = 0; x < card.width(); ++x) errors.pixels += is_near_edge(card, x, y);
    for (const Pulse& p : analyser.finish().pulses) {
        if (!is_near_edge(card, static_cast<int>(p.u), static_cast<int>(p.v))) continue;
        errors.spacetime = std::max(errors.spacetime,
                                    std::abs(card.beam_at_time(p.t_ns) - static_cast<double>(p.u)));
        ++errors.pulses;
    }
}

CardErrors measure(const ReflectanceCard& card) {
    CardErrors errors;
    errors.spatial_moment = spatial_moment(card);
    errors.spacetime_moment = spacetime_moment(card);
    std::vector<Frame> frames;
    for (int k = 0; k < card.frames(); ++k) frames.push_back(card.frame(k));
    for (const PeakMethod method : kPeakMethods)
        errors.spatial.push_back(spatial_error(card, frames, method));
    measure_spacetime(card, frames, stated_noise(), errors);
    return errors;
}

}  // namespace stria::test
