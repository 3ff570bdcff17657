#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "host/geometry/nearest.h"

namespace stria {

/// How many pitches neighbours of one surface may be apart: of points strewn at random one in 1e10
/// is farther from its nearest.
inline constexpr double kReachPitches = 6;

/// Groups of places that hang together: neighbours within reach_mm are of one group.
struct Groups {
    std::vector<std::uint32_t> of;   ///< number of each place's group
    std::vector<std::size_t> sizes;  ///< by number
    /// Number of the group with the most places (the first of equal ones); only where there is one.
    std::uint32_t largest() const;
};
Groups grow(const std::vector<Eigen::Vector3d>& places, double reach_mm);

/// Which of the groups are things of their own rather than errors about a surface, by number: at
/// least `many` points whose median distance from the surface exceeds `far_mm`.
/// @param off_mm  distance of each place from the surface
std::vector<std::uint8_t> groups_apart(const Groups& groups, const std::vector<double>& off_mm,
                                       std::size_t many, double far_mm);

/// Median distance of neighbouring places, of some hundred of them; 0 for fewer than two.
double median_pitch(const std::vector<Eigen::Vector3d>& places, const PointTree& tree);

/// The places of those indices.
std::vector<Eigen::Vector3d> places_of(const std::vector<Eigen::Vector3d>& places,
                                       const std::vector<std::uint32_t>& indices);

/// At most `most` of the indices, evenly along their order.
std::vector<std::uint32_t> thinned(const std::vector<std::uint32_t>& indices, std::size_t most);

}  // namespace stria
