#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "host/core/rigid3.h"
#include "host/registration/scan_surface.h"

namespace stria {

/// Which pairs of points may be the same place on the part.
struct MatchGates {
    double max_distance_mm = 2.0;
    double min_normal_cosine = 0.7071;  ///< 45 deg between the two normals
};

/// A sample of one scan and the nearest point of another.
struct Match {
    std::uint32_t source = 0;  ///< point of the source surface
    std::uint32_t target = 0;  ///< point of the target surface
};

/// Nearest target points of these source points that pass the gates: distance, normal angle, and
/// target point not on the border of its range image.
/// @param samples  points of the source surface; searches are fastest where neighbours in the list
///   are neighbours in space
/// @param warm  per sample the nearest target point of an earlier call with the same samples (or
///   0xffffffff; empty the first time): only speeds the search
std::vector<Match> find_matches(const ScanSurface& source, const ScanSurface& target,
                                const Rigid3& target_from_source, const MatchGates& gates,
                                std::span<const std::uint32_t> samples,
                                std::vector<std::uint32_t>& warm);

/// The first `count` samples of a scan in ascending order.
std::vector<std::uint32_t> ordered_samples(const ScanSurface& surface, std::size_t count);

/// Distance of the source point from the target point's tangent plane (mm), positive in front.
double plane_distance(const ScanSurface& source, const ScanSurface& target,
                      const Rigid3& target_from_source, const Match& match);

/// Root mean square point-to-plane distance (mm) over the samples, of every scan against every
/// other, that have a match not on a border within 2 mm and 45 degrees; 0 with no match.
/// @param world_from_scan  one a surface
/// @param sample_count  samples of each scan, at most
double overlap_rms_mm(const SurfaceList& surfaces, const std::vector<Rigid3>& world_from_scan,
                      std::size_t sample_count = 20000, const MatchGates& gates = {});

}  // namespace stria
