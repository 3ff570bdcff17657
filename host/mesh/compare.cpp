#include "host/mesh/compare.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>

#include "host/geometry/nearest.h"
#include "host/geometry/parallel.h"

namespace stria {
namespace {

bool is_used(const std::vector<std::uint8_t>& use, const std::array<std::uint32_t, 3>& t) {
    return use.empty() || (use[t[0]] && use[t[1]] && use[t[2]]);
}

std::vector<Eigen::Vector3d> used_vertices(const TriMesh& mesh,
                                           const std::vector<std::uint8_t>& use) {
    std::vector<std::uint8_t> wanted(mesh.positions.size(), 0);
    for (const auto& t : mesh.triangles)
        for (const std::uint32_t v : t) wanted[v] = use.empty() || use[v];
    std::vector<Eigen::Vector3d> points;
    for (std::size_t v = 0; v < wanted.size(); ++v)
        if (wanted[v]) points.push_back(mesh.positions[v]);
    return points;
}

void check(const TriMesh& mesh, const std::vector<std::uint8_t>& use, const char* name) {
    if (mesh.triangles.empty())
        throw std::invalid_argument(std::string("compare_meshes: mesh ") + name +
                                    " has no triangles");
    if (!use.empty() && use.size() != mesh.positions.size())
        throw std::invalid_argument(std::string("compare_meshes: use_") + name + " has " +
                                    std::to_string(use.size()) + " numbers, expected " +
                                    std::to_string(mesh.positions.size()));
}

}  // namespace

std::vector<Eigen::Vector3d> sample_surface(const TriMesh& mesh, std::size_t samples, unsigned seed,
                                            const std::vector<std::uint8_t>& use) {
    if (samples == 0) return used_vertices(mesh, use);
    std::vector<double> area_up_to(mesh.triangles.size() + 1, 0);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const auto& t = mesh.triangles[i];
        const Eigen::Vector3d& a = mesh.positions[t[0]];
        const double area = 0.5 * (mesh.positions[t[1]] - a).cross(mesh.positions[t[2]] - a).norm();
        area_up_to[i + 1] = area_up_to[i] + (is_used(use, t) ? area : 0);
    }
    std::vector<Eigen::Vector3d> points;
    if (!(area_up_to.back() > 0)) return points;
    std::mt19937 rng(seed);
    const auto uniform = [&] { return (static_cast<double>(rng()) + 0.5) / 4294967296.0; };
    for (std::size_t i = 0; i < samples; ++i) {
        // One sample in each of equal shares of the area.
        const double at =
            (static_cast<double>(i) + uniform()) / static_cast<double>(samples) * area_up_to.back();
        const auto above = std::upper_bound(area_up_to.begin(), area_up_to.end(), at);
        const auto triangle =
            std::clamp<std::ptrdiff_t>(above - area_up_to.begin() - 1, 0,
                                       static_cast<std::ptrdiff_t>(mesh.triangles.size()) - 1);
        const auto& t = mesh.triangles[static_cast<std::size_t>(triangle)];
        const double r = std::sqrt(uniform()), u = uniform();
        points.push_back((1 - r) * mesh.positions[t[0]] + r * (1 - u) * mesh.positions[t[1]] +
                         r * u * mesh.positions[t[2]]);
    }
    return points;
}

std::vector<double> distances_to_surface(const std::vector<Eigen::Vector3d>& points,
                                         const TriMesh& mesh) {
    const SurfaceTree tree(mesh);
    std::vector<double> distances(points.size());
    parallel_for_blocks(points.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto hit = tree.nearest(points[i]);
            distances[i] = hit ? hit->distance_mm : std::nan("");
        }
    });
    return distances;
}

DistanceFigures figures_of(std::vector<double> distances_mm) {
    DistanceFigures figures;
    figures.samples = distances_mm.size();
    if (distances_mm.empty()) return figures;
    std::sort(distances_mm.begin(), distances_mm.end());
    const auto n = static_cast<double>(distances_mm.size());
    double sum = 0, squares = 0;
    for (const double d : distances_mm) {
        sum += d;
        squares += d * d;
    }
    const auto quantile = [&](double share) {
        const auto rank = static_cast<std::size_t>(std::ceil(share * n));
        return distances_mm[std::max<std::size_t>(rank, 1) - 1];
    };
    figures.mean_mm = sum / n;
    figures.rms_mm = std::sqrt(squares / n);
    figures.p95_mm = quantile(0.95);
    figures.p99_mm = quantile(0.99);
    figures.max_mm = distances_mm.back();
    return figures;
}

MeshComparison compare_meshes(const TriMesh& a, const TriMesh& b, const CompareOptions& options) {
    check(a, options.use_a, "a");
    check(b, options.use_b, "b");
    MeshComparison result;
    result.a_to_b = figures_of(
        distances_to_surface(sample_surface(a, options.samples, options.seed, options.use_a), b));
    result.b_to_a = figures_of(
        distances_to_surface(sample_surface(b, options.samples, options.seed, options.use_b), a));
    result.hausdorff_mm = std::max(result.a_to_b.max_mm, result.b_to_a.max_mm);
    return result;
}

}  // namespace stria
