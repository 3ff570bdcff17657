#include "host/render/colour_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace stria {
namespace {

using Knots = std::array<Eigen::Vector3f, 9>;

/// Viridis at 0, 1/8, ... 1.
const Knots kSequential = {{{0.267f, 0.005f, 0.329f},
                            {0.279f, 0.175f, 0.483f},
                            {0.230f, 0.322f, 0.546f},
                            {0.173f, 0.449f, 0.558f},
                            {0.128f, 0.567f, 0.551f},
                            {0.158f, 0.684f, 0.502f},
                            {0.369f, 0.789f, 0.383f},
                            {0.678f, 0.864f, 0.190f},
                            {0.993f, 0.906f, 0.144f}}};

/// ColorBrewer RdBu, reversed, its middle a light grey.
const Knots kDiverging = {{{0.129f, 0.400f, 0.675f},
                           {0.263f, 0.576f, 0.765f},
                           {0.573f, 0.773f, 0.871f},
                           {0.820f, 0.898f, 0.941f},
                           {0.940f, 0.940f, 0.940f},
                           {0.992f, 0.859f, 0.780f},
                           {0.957f, 0.647f, 0.510f},
                           {0.839f, 0.376f, 0.302f},
                           {0.698f, 0.094f, 0.169f}}};

Eigen::Vector3f between(const Knots& knots, double t) {
    const double at = t * static_cast<double>(knots.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(at), knots.size() - 2);
    const auto share = static_cast<float>(at - static_cast<double>(i));
    return (1.0f - share) * knots[i] + share * knots[i + 1];
}

/// Next of 1, 2, 5 times a power of ten that is at least `value`; 1 for 0.
double round_up(double value) {
    if (!(value > 0)) return 1;
    const double power = std::pow(10.0, std::floor(std::log10(value)));
    for (const double step : {1.0, 2.0, 5.0})
        if (value <= step * power * (1 + 1e-9)) return step * power;
    return 10 * power;
}

double quantile_of(std::vector<float> values, double quantile, bool absolute) {
    std::erase_if(values, [](float v) { return !std::isfinite(v); });
    if (values.empty()) return 0;
    if (absolute)
        for (float& v : values) v = std::abs(v);
    const auto at = static_cast<std::ptrdiff_t>(quantile * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[static_cast<std::size_t>(at)];
}

}  // namespace

Eigen::Vector3f colour_of(const ColourScale& scale, double value) {
    if (std::isnan(value)) return Eigen::Vector3f::Constant(0.6f);
    const double span = scale.high - scale.low;
    const double t = span > 0 ? std::clamp((value - scale.low) / span, 0.0, 1.0) : 0.5;
    switch (scale.map) {
        case ColourMap::sequential:
            return between(kSequential, t);
        case ColourMap::diverging:
            return between(kDiverging, t);
        case ColourMap::grey:
            break;
    }
    return Eigen::Vector3f::Constant(static_cast<float>(t));
}

ColourScale symmetric_scale(const std::vector<float>& values, double quantile, std::string label,
                            std::string unit) {
    const double limit = round_up(quantile_of(values, quantile, true));
    return {ColourMap::diverging, -limit, limit, std::move(label), std::move(unit)};
}

ColourScale positive_scale(const std::vector<float>& values, double quantile, std::string label,
                           std::string unit) {
    const double limit = round_up(quantile_of(values, quantile, false));
    return {ColourMap::sequential, 0, limit, std::move(label), std::move(unit)};
}

std::vector<Eigen::Vector3f> vertex_colours(const TriMesh& mesh, const std::string& attribute,
                                            const ColourScale& scale) {
    const VertexAttribute* found = mesh.find_attribute(attribute);
    if (!found || found->components != 1 || found->values.size() != mesh.positions.size())
        throw std::invalid_argument("vertex_colours: no number '" + attribute +
                                    "' at the vertices");
    std::vector<Eigen::Vector3f> colours;
    colours.reserve(found->values.size());
    for (const float value : found->values) colours.push_back(colour_of(scale, value));
    return colours;
}

}  // namespace stria
