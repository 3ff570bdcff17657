#pragma once
#include <Eigen/Core>
#include <random>
#include <vector>

#include "host/verify/scan_points.h"

namespace stria {

/// Half thickness of the shell that counts as a sphere's, of its radius: wide against noise, narrow
/// against other things that touch it.
inline constexpr double kSphereShell = 0.05;

struct SphereSearch {
    double least_diameter_mm = 0;     ///< of those expected
    double greatest_diameter_mm = 0;  ///< looked for are 0.7 to 1.4 times these, so that a wrong
                                      ///< artefact is seen for what it is
    int most = 1;                     ///< stops when so many are found
    int trials = 4000;  ///< samples of four points a sphere; a sphere that shows in one
                        ///< point of a hundred is missed less often than once in 1e9
};

struct FoundSphere {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< mm
    double radius_mm = 0;
    std::size_t points = 0;  ///< of the scan, on it
    double sigma_mm = 0;     ///< robust, of their distances from it
};

/// Spheres in a scan with other things about, the one with the most points first. RANSAC: a sphere
/// through four points near each other must hold most of its surroundings; the best is refined
/// with all points near it. Spheres seen from inside, and patches that are too flat or too narrow
/// to tell a sphere from a plane or a rod, are none. Empty if there is none. Source: Fischler &
/// Bolles 1981; local samples after Myatt et al. 2002 (NAPSAC).
std::vector<FoundSphere> find_spheres(const ScanPoints& scan, const SphereSearch& search,
                                      std::mt19937& rng);

}  // namespace stria
