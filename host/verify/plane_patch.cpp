#include "host/verify/plane_patch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <optional>

#include "firmware/core/angle.h"
#include "firmware/core/median.h"
#include "host/core/errors.h"
#include "host/geometry/fit.h"
#include "host/geometry/nearest.h"
#include "host/verify/grow.h"

namespace stria {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kMostInSearch = 30000;
constexpr std::size_t kFewestPoints = 100;

std::optional<Plane> through(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const Vector3d normal = (b - a).cross(c - a);
    if (!(normal.norm() > 1e-6 * (b - a).norm() * (c - a).norm())) return {};
    const Vector3d unit = normal.normalized();
    return Plane{unit, unit.dot(a)};
}

/// The plane through local samples that holds the most points within the artefact's reach of them.
std::optional<Plane> best_plane(const std::vector<Vector3d>& places, const PlaneSearch& search,
                                double shell_mm, std::mt19937& rng) {
    const PointTree tree(places);
    std::optional<Plane> best;
    std::size_t best_count = 0;
    for (int trial = 0; trial < search.trials; ++trial) {
        if (trial >= 300 && 4 * best_count > places.size()) break;  // hit often by now
        const Vector3d& first = places[rng() % places.size()];
        const auto around = tree.within(first, 0.25 * search.size_mm.y());
        if (around.size() < 12) continue;
        const Vector3d& second = places[around[rng() % around.size()]];
        const auto plane = through(first, second, places[around[rng() % around.size()]]);
        if (!plane) continue;
        const auto is_on = [&](const Vector3d& p) {
            return std::abs(plane->distance(p)) < shell_mm;
        };
        std::size_t near = 0, count = 0;
        for (const std::uint32_t i : around) near += is_on(places[i]);
        if (2 * near < around.size()) continue;
        const double reach = search.size_mm.norm();
        for (const Vector3d& p : places) count += is_on(p) && (p - first).norm() < reach;
        if (count > best_count) {
            best_count = count;
            best = plane;
        }
    }
    return best;
}

Rectangle turned_rectangle(const std::vector<Vector3d>& points, const Plane& plane, double turn) {
    const Vector3d u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
    const Vector3d a = std::cos(turn) * u + std::sin(turn) * v;
    const Vector3d b = plane.normal.cross(a);
    Vector2d low = Vector2d::Constant(1e300), high = -low;
    for (const Vector3d& p : points) {
        const Vector2d at(a.dot(p), b.dot(p));
        low = low.cwiseMin(at);
        high = high.cwiseMax(at);
    }
    const Vector2d size = high - low, middle = (low + high) / 2;
    const Vector3d place = middle.x() * a + middle.y() * b + plane.offset_mm * plane.normal;
    if (size.x() >= size.y()) return {place, a, b, size};
    return {place, b, -a, {size.y(), size.x()}};
}

/// By the turn of its sides, in steps of a degree, then of a twentieth about the best.
Rectangle least_rectangle(const std::vector<Vector3d>& points, const Plane& plane) {
    double best_turn = 0;
    Rectangle best = turned_rectangle(points, plane, 0);
    const auto search = [&](double from, double step, int steps) {
        for (int i = 0; i <= steps; ++i) {
            const Rectangle other = turned_rectangle(points, plane, from + i * step);
            if (other.size_mm.prod() >= best.size_mm.prod()) continue;
            best = other;
            best_turn = from + i * step;
        }
    };
    search(kDegree, kDegree, 88);
    search(best_turn - kDegree, kDegree / 20, 40);
    return best;
}

std::optional<PlanePatch> patch_of(const ScanPoints& scan, const std::vector<std::uint32_t>& among,
                                   Plane plane, double shell_mm) {
    PlanePatch patch;
    patch.shell_mm = shell_mm;
    for (int round = 0; round < 3; ++round) {
        std::vector<std::uint32_t> on;
        for (const std::uint32_t i : among)
            if (std::abs(plane.distance(scan.positions[i])) < shell_mm) on.push_back(i);
        if (on.size() < kFewestPoints) return {};
        const std::vector<Vector3d> places = places_of(scan.positions, on);
        patch.pitch_mm = median_pitch(places, PointTree(places));
        const Groups groups = grow(places, kReachPitches * patch.pitch_mm);
        const std::uint32_t largest = groups.largest();
        std::vector<Vector3d> grown;
        patch.points.clear();
        for (std::size_t i = 0; i < on.size(); ++i) {
            if (groups.of[i] != largest) continue;
            patch.points.push_back(on[i]);
            grown.push_back(places[i]);
        }
        if (grown.size() < kFewestPoints) return {};
        const PlaneFit fit = fit_plane(grown);
        plane = {fit.normal, fit.offset_mm};
        std::vector<double> off;
        for (const Vector3d& p : grown) off.push_back(std::abs(plane.distance(p)));
        patch.sigma_mm = 1.4826 * median(off);
    }
    patch.plane = plane;
    patch.outline =
        least_rectangle(places_of(scan.positions, thinned(patch.points, kMostInSearch)), plane);
    return patch;
}

bool fits(const Vector2d& found, const Vector2d& calibrated) {
    return found.x() <= 1.05 * calibrated.x() && found.y() <= 1.05 * calibrated.y() &&
           found.x() >= 0.5 * calibrated.x() && found.y() >= 0.5 * calibrated.y();
}

std::string size_text(const Vector2d& size) {
    char text[64];
    std::snprintf(text, sizeof text, "%.4g x %.4g mm", size.x(), size.y());
    return text;
}

}  // namespace

PlanePatch find_plane_patch(const ScanPoints& scan, const PlaneSearch& search, std::mt19937& rng) {
    const double shell = kPlaneShell * search.size_mm.y();
    std::vector<std::uint32_t> left;
    for (std::uint32_t i = 0; i < scan.positions.size(); ++i) left.push_back(i);
    std::string found;
    for (int plane = 0; plane < search.most && left.size() >= kFewestPoints; ++plane) {
        const auto best =
            best_plane(places_of(scan.positions, thinned(left, kMostInSearch)), search, shell, rng);
        if (!best) break;
        const auto patch = patch_of(scan, left, *best, shell);
        if (!patch) break;
        if (fits(patch->outline.size_mm, search.size_mm)) {
            if (5 * patch->sigma_mm > shell)
                throw Error("the points scatter by " + std::to_string(patch->sigma_mm) +
                            " mm (one standard deviation) about the plane: expected at most a "
                            "500th of its shorter side");
            return *patch;
        }
        found += (found.empty() ? "" : ", ") + size_text(patch->outline.size_mm);
        std::vector<std::uint32_t> rest;
        std::set_difference(left.begin(), left.end(), patch->points.begin(), patch->points.end(),
                            std::back_inserter(rest));
        left = std::move(rest);
    }
    throw Error("found no plane of " + size_text(search.size_mm) +
                "; planes found: " + (found.empty() ? "none" : found));
}

}  // namespace stria
