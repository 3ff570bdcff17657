#include "host/verify/sphere_region.h"

#include <algorithm>
#include <cmath>

#include "host/geometry/nearest.h"
#include "host/verify/grow.h"

namespace stria {
namespace {

using Eigen::Vector3d;

/// Points about the sphere, sorted by what they are to it.
struct Surroundings {
    std::vector<std::uint32_t> on;        ///< in the shell
    std::vector<std::uint32_t> off;       ///< outside the shell, within half a radius of it
    std::vector<std::uint32_t> off_flat;  ///< of those, the ones beyond the greatest incidence
    std::size_t too_flat = 0;
};

Surroundings look_around(const ScanPoints& scan, const FoundSphere& sphere, double shell_mm,
                         double max_incidence_rad) {
    Surroundings found;
    const double least_cosine = std::cos(max_incidence_rad);
    for (std::uint32_t i = 0; i < scan.positions.size(); ++i) {
        const Vector3d offset = scan.positions[i] - sphere.centre;
        const double distance = offset.norm();
        if (std::abs(distance - sphere.radius_mm) > 0.5 * sphere.radius_mm) continue;
        const bool in_shell = std::abs(distance - sphere.radius_mm) <= shell_mm;
        const bool flat = scan.has_sight() && offset.dot(scan.towards_camera[i].cast<double>()) <
                                                  least_cosine * distance;
        if (flat && in_shell)
            ++found.too_flat;
        else
            (in_shell ? found.on : flat ? found.off_flat : found.off).push_back(i);
    }
    return found;
}

}  // namespace

SphereRegion sphere_region(const ScanPoints& scan, const FoundSphere& sphere,
                           const SphereRegionOptions& options) {
    SphereRegion region;
    const double shell =
        std::clamp(10 * sphere.sigma_mm, 0.005 * sphere.radius_mm, kSphereShell * sphere.radius_mm);
    const Surroundings around = look_around(scan, sphere, shell, options.max_incidence_rad);
    region.too_flat = around.too_flat;
    if (around.on.size() < 2) return region;
    const std::vector<Vector3d> on_places = places_of(scan.positions, around.on);
    region.pitch_mm = median_pitch(on_places, PointTree(on_places));
    const double reach = kReachPitches * region.pitch_mm;

    // Groups off the shell: many together are a thing, few are errors of the measurement. Other
    // things may be scanned more sparsely.
    std::vector<std::uint32_t> all_off = around.off;
    all_off.insert(all_off.end(), around.off_flat.begin(), around.off_flat.end());
    const Groups off = grow(places_of(scan.positions, all_off), 2 * reach);
    std::vector<double> off_mm;
    for (const std::uint32_t i : all_off)
        off_mm.push_back(std::abs((scan.positions[i] - sphere.centre).norm() - sphere.radius_mm));
    const std::vector<std::uint8_t> apart =
        groups_apart(off, off_mm, std::max<std::size_t>(30, around.on.size() / 200),
                     kSphereShell * sphere.radius_mm);
    std::vector<Vector3d> things;
    std::vector<std::uint32_t> strays;
    for (std::size_t i = 0; i < all_off.size(); ++i) {
        if (apart[off.of[i]] != 0)
            things.push_back(scan.positions[all_off[i]]);
        else if (i < around.off.size() && off_mm[i] < 0.25 * sphere.radius_mm)
            strays.push_back(all_off[i]);
    }

    // A tangent plane leaves the shell this far from where it touches.
    const double keep_out = std::sqrt(2 * sphere.radius_mm * shell) + 2 * region.pitch_mm;
    const PointTree thing_tree(things);
    const Groups on = grow(on_places, reach);
    const std::uint32_t largest = on.largest();
    for (std::size_t i = 0; i < around.on.size(); ++i) {
        if (on.of[i] == largest && !thing_tree.nearest(on_places[i], keep_out))
            region.points.push_back(around.on[i]);
    }
    region.beside = things.size() + around.on.size() - region.points.size();
    for (const std::uint32_t i : strays)
        if (!thing_tree.nearest(scan.positions[i], keep_out)) region.points.push_back(i);
    std::sort(region.points.begin(), region.points.end());
    return region;
}

}  // namespace stria
