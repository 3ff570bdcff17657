#pragma once
#include <cstdint>
#include <vector>

#include "host/verify/find_spheres.h"
#include "host/verify/scan_points.h"

namespace stria {

struct SphereRegionOptions {
    /// Greatest angle between the surface's normal and the way to the camera: nearer to a sphere's
    /// horizon sensors show its edge, not its surface. Applies where the scan knows its sight.
    double max_incidence_rad = 1.0471975511965976;  // 60 deg
};

/// The part of a scan that measures one sphere.
struct SphereRegion {
    std::vector<std::uint32_t> points;  ///< indices, ascending
    std::size_t beside = 0;    ///< points within half a radius of the sphere that belong to other
                               ///< things (a stand), and those of the sphere that are next to them
    std::size_t too_flat = 0;  ///< on the sphere, seen flatter than the greatest incidence
    double pitch_mm = 0;       ///< median distance of neighbouring points
};

/// Region growing about a sphere. Points in its shell that hang together are its surface. Groups of
/// neighbouring points off the shell are other things if they are many (30, or one of 200) and
/// mostly farther than kSphereShell; the surface next to them is left out too. All other points
/// off the shell stay: they are what the scanner measured of the sphere, and count as its form
/// error unless the procedure rejects them.
SphereRegion sphere_region(const ScanPoints& scan, const FoundSphere& sphere,
                           const SphereRegionOptions& options = {});

}  // namespace stria
