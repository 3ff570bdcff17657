#pragma once
#include <Eigen/Core>

namespace stria {

/// Irradiance at `point` on a surface with unit `normal` from a parallelogram of radiance 1
/// (centre +- half_a +- half_b), both faces alike: Lambert's formula 1/2 sum theta_i n . gamma_i
/// over its edges, the part below the point's horizon cut off (Lambert 1760; Arvo 1995, eq. 2.9).
/// Times 1 / pi it is the form factor from the point.
double parallelogram_irradiance(const Eigen::Vector3d& point, const Eigen::Vector3d& normal,
                                const Eigen::Vector3d& centre, const Eigen::Vector3d& half_a,
                                const Eigen::Vector3d& half_b);

}  // namespace stria
