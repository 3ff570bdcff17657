#pragma once
#include <Eigen/Core>
#include <array>

namespace stria {

/// A convex body round everything measured: planes normal . p <= offset. Beyond it the filled
/// surface takes space for empty, as Curless & Levoy close theirs at the volume's box; a body with
/// 26 sides wastes less.
struct ClosingBody {
    static constexpr int kAxes = 13;
    std::array<double, kAxes> low;
    std::array<double, kAxes> high;

    ClosingBody();
    /// Unit normal of the k-th pair of planes.
    static const Eigen::Vector3d& axis(int k);
    void include(const Eigen::Vector3d& point);
    void grow(double mm);
    /// Share of a ball that may lie in the body: 0 none, 1 some, 2 all of it.
    int holds(const Eigen::Vector3d& centre, double radius_mm) const;
};

}  // namespace stria
