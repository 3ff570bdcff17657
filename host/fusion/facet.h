#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "host/fusion/range_surface.h"

namespace stria {

/// How far from the surface its distance is written, along the normal, mm.
struct RampLengths {
    double front_mm = 0;  ///< full weight up to here in front; grows by 3 sigma of each triangle
    double tail_mm = 0;   ///< weight falls from full at half of it to 0 behind the surface
};

/// Lines of sight longer than this many times the ramp are cut: seen at a flat angle, a place may
/// be close to the plane of a triangle and yet far along the line.
constexpr double kGrazingFactor = 2;

/// The plane of sight through an edge. Both triangles of the edge build it from the lower vertex
/// number to the higher, so that their tests are opposite to the last bit; a voxel exactly on it
/// counts as moved by a fixed odd direction.
struct SightPlane {
    Eigen::Vector3d normal;
    double offset;
    bool forwards;  ///< this triangle runs from the lower to the higher vertex
    bool tie_positive;

    /// Value at x = 0 of a row; at(row, x) is the same bits for both triangles of the edge.
    double row(double y, double z) const { return normal.y() * y + normal.z() * z - offset; }
    double at(double row_value, double x) const { return row_value + normal.x() * x; }
    bool inside(double value) const {
        const bool positive = value > 0 || (value == 0 && tie_positive);
        return positive == forwards;
    }
};

/// Closed box of voxels.
struct VoxelBox {
    Eigen::Vector3i min, max;
};

/// A triangle as the rasteriser needs it, world frame.
struct Facet {
    Eigen::Vector3d normal;   ///< unit, towards the camera
    double height;            ///< normal . p = height in the triangle's plane
    Eigen::Vector3d station;  ///< mean camera of the corners; unused if orthographic
    SightPlane plane[3];      ///< of the sides 0-1, 1-2, 2-0
    double front_mm, tail_mm;
    VoxelBox reach;  ///< voxels that its ramp can reach

    /// False if surely no voxel of a box (centre, half its side) lies in the ramp.
    bool may_touch(const Eigen::Vector3d& centre, double half_side) const;
};

/// Facets of all triangles of a surface. Throws stria::Error if a point lies too far from the
/// origin for voxels of that size.
std::vector<Facet> make_facets(const RangeSurface& surface, const RampLengths& ramp,
                               double voxel_mm);

}  // namespace stria
