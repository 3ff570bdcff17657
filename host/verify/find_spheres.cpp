#include "host/verify/find_spheres.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "firmware/core/median.h"
#include "host/geometry/fit.h"
#include "host/geometry/nearest.h"
#include "host/verify/grow.h"

namespace stria {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kMostInSearch = 30000;  // thinned: enough for a sphere of 1 % of a scan
constexpr std::size_t kFewestPoints = 100;    // less is no measurement
constexpr double kLeastSpread_rad = 0.21;  // sd of the directions: a disc of 24 deg; a plane or a
                                           // rod that touches the shell has at most 0.18

struct Candidate {
    Vector3d centre;
    double radius_mm;
};

/// Whether the point lies on the outside of the sphere that the camera sees.
bool is_on(const ScanPoints& scan, std::uint32_t i, const Candidate& sphere, double shell_mm) {
    const Vector3d offset = scan.positions[i] - sphere.centre;
    if (std::abs(offset.norm() - sphere.radius_mm) > shell_mm) return false;
    return !scan.has_sight() || scan.towards_camera[i].cast<double>().dot(offset) > 0;
}

std::size_t count_on(const ScanPoints& scan, const std::vector<std::uint32_t>& among,
                     const Candidate& sphere) {
    std::size_t count = 0;
    for (const std::uint32_t i : among)
        count += is_on(scan, i, sphere, kSphereShell * sphere.radius_mm);
    return count;
}

std::optional<Candidate> through(const std::array<Vector3d, 4>& p) {
    Eigen::Matrix3d rows;
    Vector3d right;
    for (int i = 0; i < 3; ++i) {
        const Vector3d edge = p[static_cast<std::size_t>(i) + 1] - p[0];
        rows.row(i) = 2 * edge.transpose();
        right(i) = edge.squaredNorm();
    }
    const Vector3d offset = rows.partialPivLu().solve(right);
    if (!offset.allFinite()) return {};
    return Candidate{p[0] + offset, offset.norm()};
}

/// The sphere through local samples that holds the most of `among`.
std::optional<Candidate> best_candidate(const ScanPoints& scan,
                                        const std::vector<std::uint32_t>& among,
                                        const SphereSearch& search, std::mt19937& rng) {
    std::vector<Vector3d> places;
    for (const std::uint32_t i : among) places.push_back(scan.positions[i]);
    const PointTree tree(places);
    const double least = 0.35 * search.least_diameter_mm, most = 0.7 * search.greatest_diameter_mm;
    std::optional<Candidate> best;
    std::size_t best_count = 0;
    for (int trial = 0; trial < search.trials; ++trial) {
        if (trial >= 300 && 4 * best_count > among.size()) break;  // hit often by now
        const Vector3d& first = places[rng() % places.size()];
        std::vector<std::uint32_t> around = tree.within(first, 0.4 * search.least_diameter_mm);
        if (around.size() < 12) continue;
        std::array<Vector3d, 4> sample = {first, first, first, first};
        for (std::size_t k = 1; k < 4; ++k) sample[k] = places[around[rng() % around.size()]];
        const std::optional<Candidate> sphere = through(sample);
        if (!sphere || sphere->radius_mm < least || sphere->radius_mm > most) continue;
        for (std::uint32_t& i : around) i = among[i];
        if (2 * count_on(scan, around, *sphere) < around.size()) continue;
        const std::size_t count = count_on(scan, among, *sphere);
        if (count > best_count) {
            best_count = count;
            best = sphere;
        }
    }
    return best;
}

/// Smaller standard deviation (rad) of the directions about their mean.
double least_spread(const std::vector<Vector3d>& points, const Vector3d& centre) {
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& p : points) mean += (p - centre).normalized();
    mean /= static_cast<double>(points.size());
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const Vector3d& p : points) {
        const Vector3d off = (p - centre).normalized() - mean;
        scatter += off * off.transpose();
    }
    scatter /= static_cast<double>(points.size());
    return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvalues()(1));
}

/// With all points near it: fitted again in a shell that follows their noise.
std::optional<FoundSphere> refined(const ScanPoints& scan, Candidate sphere) {
    double shell = kSphereShell * sphere.radius_mm;
    FoundSphere found;
    for (int round = 0; round < 6; ++round) {
        std::vector<Vector3d> on;
        for (std::uint32_t i = 0; i < scan.positions.size(); ++i)
            if (is_on(scan, i, sphere, shell)) on.push_back(scan.positions[i]);
        if (on.size() < kFewestPoints || least_spread(on, sphere.centre) < kLeastSpread_rad)
            return {};
        const SphereFit fit = fit_sphere(on);
        if (!(fit.radius_mm > 0)) return {};
        std::vector<double> off;
        for (const Vector3d& p : on)
            off.push_back(std::abs((p - fit.centre).norm() - fit.radius_mm));
        sphere = {fit.centre, fit.radius_mm};
        found = {fit.centre, fit.radius_mm, on.size(), 1.4826 * median(off)};
        shell = std::clamp(8 * found.sigma_mm, 0.004 * fit.radius_mm, kSphereShell * fit.radius_mm);
    }
    return found;
}

}  // namespace

std::vector<FoundSphere> find_spheres(const ScanPoints& scan, const SphereSearch& search,
                                      std::mt19937& rng) {
    std::vector<std::uint32_t> left;
    for (std::uint32_t i = 0; i < scan.positions.size(); ++i) left.push_back(i);
    std::vector<FoundSphere> spheres;
    while (static_cast<int>(spheres.size()) < search.most && left.size() >= kFewestPoints) {
        const auto candidate = best_candidate(scan, thinned(left, kMostInSearch), search, rng);
        if (!candidate) break;
        const auto found = refined(scan, *candidate);
        if (!found) break;
        spheres.push_back(*found);
        std::erase_if(left, [&](std::uint32_t i) {
            return (scan.positions[i] - found->centre).norm() < 1.2 * found->radius_mm;
        });
    }
    return spheres;
}

}  // namespace stria
