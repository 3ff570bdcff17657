#pragma once
#include <numbers>

namespace stria {

/// One degree in radians: `10 * kDegree` is an angle, `angle / kDegree` its degrees.
constexpr double kDegree = std::numbers::pi / 180;

}  // namespace stria
