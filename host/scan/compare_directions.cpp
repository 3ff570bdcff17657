#include "host/scan/compare_directions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "firmware/core/median.h"

namespace stria {
namespace {

constexpr std::size_t kFewestPairs = 100;
constexpr std::size_t kMostPairs = 20000;     ///< that axis_sigma_s is measured by
constexpr double kMedianOfAbsolute = 0.6745;  ///< of a Gaussian, in standard deviations
constexpr double kNearWidths = 3;
constexpr double kWeaker = 0.8;
constexpr std::size_t kFewestKept = 2;  ///< pulses a cell that every analyser keeps
constexpr std::uint16_t kMixed =
    kPulseSpatialFallback | kPulseOverlapping | kPulseWidthOutOfRange | kPulseTouchesSequenceEnd;

/// A pass and what its pulses say of it.
struct Way {
    PulseMap& map;
    bool is_back = false;
    std::vector<double> seen_s;  ///< ascending, of all pulses; only where frames were lost

    const Pulse& any() const { return map.pulses.front(); }
    /// Whether frames were taken at s: any pulse there tells.
    bool was_there(double s, double width_s) const {
        if (map.frames_dropped == 0) return true;
        const auto next = std::lower_bound(seen_s.begin(), seen_s.end(), s - width_s / 2);
        return next != seen_s.end() && *next < s + width_s / 2;
    }
};

double width_of_s(const Pulse& pulse) {
    return static_cast<double>(pulse.width) * 1e-9 * std::abs(pulse.ds_dt);
}

std::vector<Way> ways_of(std::span<PulseMap> passes) {
    std::vector<Way> ways;
    for (PulseMap& map : passes) {
        if (map.pulses.empty() || map.mode != StripeMode::spacetime) continue;
        Way& way = ways.emplace_back(Way{map, map.pulses.front().ds_dt < 0, {}});
        if (map.frames_dropped == 0) continue;
        for (const Pulse& pulse : map.pulses) way.seen_s.push_back(pulse.s);
        std::sort(way.seen_s.begin(), way.seen_s.end());
    }
    return ways;
}

bool are_comparable(const Way& a, const Way& b) {
    return a.is_back != b.is_back && a.any().laser_id == b.any().laser_id &&
           a.map.width == b.map.width && a.map.height == b.map.height;
}

struct Difference {
    double s = 0, variance = 0;
};

std::vector<Difference> differences_between(const std::vector<Way>& ways) {
    std::vector<Difference> differences;
    for (std::size_t i = 0; i < ways.size(); ++i)
        for (std::size_t k = i + 1; k < ways.size(); ++k) {
            if (!are_comparable(ways[i], ways[k])) continue;
            for (std::size_t cell = 0; cell + 1 < ways[i].map.cell_begin.size(); ++cell) {
                const Pulse* one = clean_pulse(ways[i].map, cell);
                const Pulse* other = clean_pulse(ways[k].map, cell);
                if (!one || !other || !same_pixel(*one, *other)) continue;
                differences.push_back({one->s - other->s, std::pow(sigma_of_s(*one), 2) +
                                                              std::pow(sigma_of_s(*other), 2)});
            }
        }
    return differences;
}

/// The standard deviation that each position carries besides, which makes the median of
/// |difference| that of a Gaussian of its variance.
double axis_sigma_of(const std::vector<Difference>& differences) {
    const std::size_t stride = 1 + differences.size() / kMostPairs;
    const auto median_ratio = [&](double sigma) {
        std::vector<double> ratios;
        for (std::size_t i = 0; i < differences.size(); i += stride)
            ratios.push_back(std::abs(differences[i].s) /
                             std::sqrt(differences[i].variance + 2 * sigma * sigma));
        return median(std::move(ratios));
    };
    double low = 0, high = 0;
    for (const Difference& difference : differences) high = std::max(high, std::abs(difference.s));
    if (median_ratio(0) <= kMedianOfAbsolute) return 0;
    for (int halving = 0; halving < 40; ++halving) {
        const double middle = (low + high) / 2;
        (median_ratio(middle) > kMedianOfAbsolute ? low : high) = middle;
    }
    return high;
}

enum class Answer : std::uint8_t { same, elsewhere, nothing, untold };

/// Compares the pulses of one pass with those of others.
class Comparison {
  public:
    Comparison(const DirectionOptions& options, double axis_sigma_s)
        : options_(options), axis_sigma_s_(axis_sigma_s) {}

    /// Whether a pass of this exposure must show the pulse.
    bool must_be_seen(const Pulse& pulse) const {
        const double margin = kNearWidths * width_of_s(pulse);
        const double noise =
            std::sqrt(sample_variance(options_.noise, static_cast<double>(pulse.background)));
        const double height = static_cast<double>(pulse.amplitude);
        return (pulse.flags & kMixed) == 0 && sigma_of_s(pulse) > 0 &&
               pulse.s - margin > std::min(options_.from, options_.to) &&
               pulse.s + margin < std::max(options_.from, options_.to) &&
               height >= options_.min_snr * noise && height >= options_.min_amplitude_dn;
    }

    Answer answer_of(const Way& other, std::size_t cell, const Pulse& pulse) const {
        const std::span<const Pulse> there(
            other.map.pulses.data() + other.map.cell_begin[cell],
            other.map.pulses.data() + other.map.cell_begin[cell + 1]);
        bool is_near = false, is_mixed = false;
        std::size_t not_weaker = 0;
        for (const Pulse& one : there) {
            const double off = std::abs(one.s - pulse.s);
            if (off <= kSamePlace * std::hypot(sigma_of_s(one), sigma_of_s(pulse),
                                               std::sqrt(2.0) * axis_sigma_s_))
                return Answer::same;
            not_weaker += one.amplitude > static_cast<float>(kWeaker) * pulse.amplitude;
            if (off > kNearWidths * std::max(width_of_s(one), width_of_s(pulse))) continue;
            is_near = true;
            is_mixed = is_mixed || (one.flags & kMixed) != 0;
        }
        if (is_mixed || not_weaker >= kFewestKept) return Answer::untold;
        if (is_near) return Answer::elsewhere;
        return other.was_there(pulse.s, width_of_s(pulse)) ? Answer::nothing : Answer::untold;
    }

  private:
    const DirectionOptions& options_;
    double axis_sigma_s_;
};

/// What all opposite passes have to say of a pass's pulses.
std::vector<Answer> answers_to(const Way& way, const std::vector<Way>& ways,
                               const Comparison& comparison) {
    std::vector<Answer> answers(way.map.pulses.size(), Answer::untold);
    for (std::size_t cell = 0; cell + 1 < way.map.cell_begin.size(); ++cell)
        for (std::size_t i = way.map.cell_begin[cell]; i < way.map.cell_begin[cell + 1]; ++i) {
            const Pulse& pulse = way.map.pulses[i];
            const bool must_be_seen = comparison.must_be_seen(pulse);
            for (const Way& other : ways) {
                if (!are_comparable(way, other) || answers[i] == Answer::same) continue;
                const Answer next = comparison.answer_of(other, cell, pulse);
                const bool is_like = way.any().exposure_index == other.any().exposure_index;
                if (next == Answer::same || (next != Answer::untold && must_be_seen && is_like))
                    answers[i] = next;
            }
        }
    return answers;
}

bool is_denial(Answer answer) { return answer == Answer::nothing || answer == Answer::elsewhere; }

/// Marks the cells of the passes' grid in which a pulse is denied.
void mark_denied(const Way& way, const std::vector<Answer>& answers, std::vector<bool>& denied) {
    denied.resize(std::max(denied.size(), way.map.cell_begin.size()));
    for (std::size_t cell = 0; cell + 1 < way.map.cell_begin.size(); ++cell)
        for (std::size_t i = way.map.cell_begin[cell]; i < way.map.cell_begin[cell + 1]; ++i)
            if (is_denial(answers[i])) denied[cell] = true;
}

void flag(Way& way, const std::vector<Answer>& answers, const std::vector<bool>& denied,
          DirectionComparison& result) {
    for (std::size_t cell = 0; cell + 1 < way.map.cell_begin.size(); ++cell)
        for (std::size_t i = way.map.cell_begin[cell]; i < way.map.cell_begin[cell + 1]; ++i) {
            const Answer answer = answers[i];
            const bool is_beside = answer == Answer::untold && denied[cell];
            result.agreeing += answer == Answer::same;
            result.unseen += answer == Answer::nothing;
            result.displaced += answer == Answer::elsewhere;
            result.beside += is_beside;
            result.untold += answer == Answer::untold && !is_beside;
            if (is_denial(answer) || is_beside) way.map.pulses[i].flags |= kPulseGhostSuspected;
        }
}

}  // namespace

double sigma_of_s(const Pulse& pulse) {
    return static_cast<double>(pulse.sigma) * 1e-9 * std::abs(pulse.ds_dt);
}

const Pulse* clean_pulse(const PulseMap& map, std::size_t cell) {
    const std::uint32_t begin = map.cell_begin[cell];
    if (map.cell_begin[cell + 1] != begin + 1) return nullptr;
    const Pulse& pulse = map.pulses[begin];
    return pulse.flags == 0 && sigma_of_s(pulse) > 0 ? &pulse : nullptr;
}

bool same_pixel(const Pulse& a, const Pulse& b) {
    return a.u == b.u && a.v == b.v && a.laser_id == b.laser_id;
}

std::optional<DirectionComparison> compare_directions(std::span<PulseMap> passes,
                                                      const DirectionOptions& options) {
    std::vector<Way> ways = ways_of(passes);
    const std::vector<Difference> differences = differences_between(ways);
    if (differences.size() < kFewestPairs) return std::nullopt;
    DirectionComparison result;
    result.axis_sigma_s = axis_sigma_of(differences);
    for (Way& way : ways)
        for (Pulse& pulse : way.map.pulses)
            pulse.flags = static_cast<std::uint16_t>(pulse.flags & ~kPulseGhostSuspected);
    const Comparison comparison(options, result.axis_sigma_s);
    std::vector<std::vector<Answer>> answers;
    std::vector<bool> denied;
    for (const Way& way : ways) {
        answers.push_back(answers_to(way, ways, comparison));
        mark_denied(way, answers.back(), denied);
    }
    for (std::size_t k = 0; k < ways.size(); ++k) flag(ways[k], answers[k], denied, result);
    return result;
}

}  // namespace stria
