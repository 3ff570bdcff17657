#pragma once
#include <random>
#include <vector>

#include "host/core/range_image.h"
#include "host/core/rigid3.h"
#include "host/core/tri_mesh.h"
#include "host/geometry/nearest.h"

namespace stria::testing {

/// A closed lumpy shape about the origin, near 100 mm across, without symmetry: a sphere whose
/// radius is moved by smooth bumps of several sizes. Triangles of about 1 mm at level 6.
/// @param seed  another shape
TriMesh make_bumpy_shape(unsigned seed, int level = 6);

struct ViewOptions {
    int width = 160, height = 160;
    double pitch_mm = 0.7;     ///< at the distance of the origin
    double distance_mm = 300;  ///< of the camera from the origin
    double baseline_mm = 100;  ///< laser to the right of the camera
    double sigma_mm = 0;       ///< noise along the ray; known to the points
};

/// world_from_scan of a camera that looks from `direction` at the origin, turned by `roll_rad`.
/// Scan frame: camera at the origin, y up, looking along -z.
Rigid3 looking_from(const Eigen::Vector3d& direction, double distance_mm, double roll_rad = 0);

/// Range image of what both the camera and the laser see; one perspective station.
RangeImage take_view(const SurfaceTree& shape, const Rigid3& world_from_scan,
                     const ViewOptions& options, std::mt19937& rng);

/// `count` directions spread evenly over the sphere (a golden-angle spiral).
std::vector<Eigen::Vector3d> spread_directions(int count);

/// A motion that turns by angle_rad about a random axis through `centre` and shifts by shift_mm in
/// a random direction.
Rigid3 random_motion(const Eigen::Vector3d& centre, double angle_rad, double shift_mm,
                     std::mt19937& rng);

}  // namespace stria::testing
