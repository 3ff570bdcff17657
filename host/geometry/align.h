#pragma once
#include <Eigen/Core>
#include <span>

#include "host/core/rigid3.h"

namespace stria {

/// Rigid motion that best moves `from` onto `to` point by point: least squares of
/// |to_i - motion * from_i|^2 with optional weights. Needs 3 non-collinear pairs, else the
/// rotation left open is arbitrary but valid. Source: Umeyama 1991 without scale.
Rigid3 align_points(std::span<const Eigen::Vector3d> from, std::span<const Eigen::Vector3d> to,
                    std::span<const double> weights = {});

}  // namespace stria
