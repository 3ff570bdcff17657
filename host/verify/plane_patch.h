#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <vector>

#include "host/verify/scan_points.h"

namespace stria {

/// Half thickness of what counts as on a plane at first, of the artefact's shorter side: wide
/// against noise, narrow against other things.
inline constexpr double kPlaneShell = 0.01;

struct PlaneSearch {
    Eigen::Vector2d size_mm{0, 0};  ///< of the artefact, longer side first
    double margin_mm = 0;           ///< left out along the patch's border
    int trials = 2000;              ///< samples of three points a plane
    int most = 8;                   ///< planes looked at before it is given up
};

/// normal . p = offset_mm, unit normal.
struct Plane {
    Eigen::Vector3d normal;
    double offset_mm;
    double distance(const Eigen::Vector3d& p) const { return normal.dot(p) - offset_mm; }
};

/// Least rectangle about points of a plane.
struct Rectangle {
    Eigen::Vector3d middle, along, across;  ///< unit vectors of the longer and the shorter side
    Eigen::Vector2d size_mm;                ///< longer side first
};

/// A connected patch of one plane.
struct PlanePatch {
    Plane plane;
    std::vector<std::uint32_t> points;  ///< indices, ascending
    Rectangle outline;
    double shell_mm = 0;  ///< farther from the plane is another thing, or an error
    double pitch_mm = 0;  ///< median distance of neighbouring points
    double sigma_mm = 0;  ///< robust, of the distances from the plane
};

/// The patch of a scan that has the artefact's size (each side between half and 1.05 of it): planes
/// by RANSAC from local samples, the one with the most points first, grown to connected patches.
/// Throws stria::Error with the sizes of those found instead, and for points that scatter by more
/// than a 500th of the shorter side. Source: Fischler & Bolles 1981.
PlanePatch find_plane_patch(const ScanPoints& scan, const PlaneSearch& search, std::mt19937& rng);

}  // namespace stria
