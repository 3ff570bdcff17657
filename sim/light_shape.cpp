#include "sim/light_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace stria {
namespace {

/// Borders of the six parts of a chi-squared number of three degrees of freedom.
constexpr std::array kBorders = {0.0, 0.12, 0.4, 0.95, 2.0, 4.0};

struct VariancePart {
    double mean = 0, share = 0;
};

/// Chance that it lies below v, three degrees of freedom.
double chi3_below(double v) {
    return std::isinf(v) ? 1
                         : std::erf(std::sqrt(v / 2)) -
                               std::sqrt(2 * v / std::numbers::pi) * std::exp(-v / 2);
}

/// A third of the integral of x times its density from 0 to v: the chance for five.
double chi5_below(double v) {
    if (std::isinf(v)) return 1;
    return chi3_below(v) -
           std::sqrt(2 / std::numbers::pi) / 3 * v * std::sqrt(v) * std::exp(-v / 2);
}

std::array<VariancePart, kBorders.size()> variance_parts() {
    std::array<VariancePart, kBorders.size()> parts;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const double low = kBorders[i];
        const double high =
            i + 1 < parts.size() ? kBorders[i + 1] : std::numeric_limits<double>::infinity();
        parts[i].share = chi3_below(high) - chi3_below(low);
        parts[i].mean = 3 * (chi5_below(high) - chi5_below(low)) / parts[i].share;
    }
    return parts;
}

}  // namespace

LightParts::LightParts(const Scene& scene) {
    const double lobe = scene.line.lobe;
    has_lobe_ = lobe > 0;
    // (G(x) + lobe G((x - shift) / 2)) / (1 + 2 lobe): the power of G alone.
    profile_[0].peak = 1 / (1 + 2 * lobe);
    profile_[1] = {lobe / (1 + 2 * lobe), scene.line.lobe_shift, 2};
    has_inside_ = std::any_of(scene.objects.begin(), scene.objects.end(),
                              [](const SceneObject& object) { return object.subsurface > 0; });
}

void LightParts::add_part(const StripeLight& light, const Component& part, double extra2,
                          double share, const LightShape& shape, double shift,
                          std::vector<StripeLight>& lights) const {
    const double width = std::sqrt(part.width * part.width + extra2);
    const double per_s = static_cast<double>(light.per_s);
    StripeLight moved = light;
    moved.s0 += static_cast<double>(shape.way) * (part.shift + shift) / per_s;
    moved.per_s = static_cast<float>(per_s / width);
    moved.rate *= static_cast<float>(share * part.peak * part.width / width);
    lights.push_back(moved);
}

void LightParts::add(const StripeLight& light, double footprint2, const LightShape& shape,
                     std::vector<StripeLight>& lights) const {
    static const auto kParts = variance_parts();
    const double inside = static_cast<double>(shape.inside);
    const double spread2 = static_cast<double>(shape.spread) * static_cast<double>(shape.spread);
    for (std::size_t i = 0; i < (has_lobe_ ? 2u : 1u); ++i) {
        const Component& part = profile_[i];
        add_part(light, part, footprint2, 1 - inside, shape, 0, lights);
        if (inside <= 0) continue;
        for (const VariancePart& v : kParts)
            add_part(light, part, footprint2 + spread2 * v.mean, inside * v.share, shape,
                     static_cast<double>(shape.shift), lights);
    }
}

}  // namespace stria
