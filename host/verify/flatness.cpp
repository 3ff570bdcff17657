#include "host/verify/flatness.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/core/errors.h"
#include "host/geometry/fit.h"
#include "host/geometry/nearest.h"
#include "host/verify/grow.h"

namespace stria {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kFewestPoints = 100;

/// The patch's points inside the margin, and single points off it; without other things and what
/// is next to them.
std::vector<std::uint32_t> points_that_count(const ScanPoints& scan, const PlanePatch& patch,
                                             const PlaneSearch& search, std::size_t& beside) {
    const Vector2d half = patch.outline.size_mm / 2 -
                          Vector2d::Constant(search.margin_mm - 1e-9 * search.size_mm.x());
    const double reach = 0.05 * search.size_mm.y();
    std::vector<std::uint8_t> on(scan.positions.size(), 0);
    for (const std::uint32_t i : patch.points) on[i] = 1;
    std::vector<std::uint32_t> off, inside;
    for (std::uint32_t i = 0; i < scan.positions.size(); ++i) {
        const Vector3d from_middle = scan.positions[i] - patch.outline.middle;
        if (std::abs(from_middle.dot(patch.outline.along)) > half.x() ||
            std::abs(from_middle.dot(patch.outline.across)) > half.y() ||
            std::abs(patch.plane.distance(scan.positions[i])) > reach)
            continue;
        (on[i] != 0 ? inside : off).push_back(i);
    }
    const std::vector<Vector3d> off_places = places_of(scan.positions, off);
    const Groups groups = grow(off_places, 2 * kReachPitches * patch.pitch_mm);
    std::vector<double> off_mm;
    for (const Vector3d& place : off_places)
        off_mm.push_back(std::abs(patch.plane.distance(place)));
    const std::vector<std::uint8_t> apart =
        groups_apart(groups, off_mm, std::max<std::size_t>(30, patch.points.size() / 200),
                     kPlaneShell * search.size_mm.y());
    std::vector<Vector3d> things;
    std::vector<std::uint32_t> strays;
    for (std::size_t i = 0; i < off.size(); ++i) {
        if (apart[groups.of[i]] != 0)
            things.push_back(off_places[i]);
        else
            strays.push_back(off[i]);
    }
    const PointTree thing_tree(things);
    const double keep_out = patch.shell_mm + 3 * patch.pitch_mm;
    inside.insert(inside.end(), strays.begin(), strays.end());
    std::vector<std::uint32_t> count;
    for (const std::uint32_t i : inside)
        if (!thing_tree.nearest(scan.positions[i], keep_out)) count.push_back(i);
    beside = things.size() + inside.size() - count.size();
    std::sort(count.begin(), count.end());
    return count;
}

std::vector<double> distances_from(const PlaneFit& fit, const std::vector<Vector3d>& points) {
    std::vector<double> distances;
    for (const Vector3d& p : points) distances.push_back(fit.normal.dot(p) - fit.offset_mm);
    return distances;
}

void evaluate(MeasuredPlane& plane) {
    const std::vector<Vector3d>& places = plane.points.positions;
    std::vector<std::uint8_t> kept =
        keep_mask(distances_from(fit_plane(places), places), most_rejected(places.size()));
    std::vector<Vector3d> used;
    for (std::size_t i = 0; i < places.size(); ++i)
        if (kept[i] != 0) used.push_back(places[i]);
    PlaneFit fit = fit_plane(used);
    plane.incidence_rad = std::numeric_limits<double>::quiet_NaN();
    if (plane.points.has_sight()) {
        const Vector3d sight = plane.points.towards_camera[places.size() / 2].cast<double>();
        if (fit.normal.dot(sight) < 0) {
            fit.normal = -fit.normal;
            fit.offset_mm = -fit.offset_mm;
        }
        plane.incidence_rad = std::acos(std::min(1.0, fit.normal.dot(sight)));
    }
    plane.normal = fit.normal;
    const std::vector<Vector3d> normals(places.size(), fit.normal);
    plane.form =
        form_figures(distances_from(fit, places), std::move(kept), 3, plane.points, normals);
}

}  // namespace

MeasuredPlane measure_plane(const ScanPoints& scan, const PlaneSearch& search, std::mt19937& rng) {
    const PlanePatch patch = find_plane_patch(scan, search, rng);
    MeasuredPlane plane;
    plane.pitch_mm = patch.pitch_mm;
    plane.centre = patch.outline.middle;
    plane.along = patch.outline.along;
    plane.size_mm = patch.outline.size_mm;
    plane.used_mm = plane.size_mm - Vector2d::Constant(2 * search.margin_mm);
    plane.points = chosen(scan, points_that_count(scan, patch, search, plane.beside));
    if (plane.points.positions.size() < kFewestPoints)
        throw Error("the plane shows in " + std::to_string(plane.points.positions.size()) +
                    " points inside its margin, expected at least " +
                    std::to_string(kFewestPoints));
    evaluate(plane);
    return plane;
}

}  // namespace stria
