#include "host/cli/demo/demo_measure.h"

#include <algorithm>
#include <cmath>

#include "firmware/core/median.h"
#include "host/geometry/nearest.h"
#include "host/geometry/parallel.h"
#include "host/geometry/range_grid.h"

namespace stria {
namespace {

using Eigen::Vector3d;
constexpr double kSmoothMm = 3.0;  // creases nearer than this are not "smooth"

double percentile(const std::vector<double>& sorted, double share) {
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

/// What one comparison of a point gave.
struct Compared {
    bool counts = false;
    bool smooth = false;
    double distance_mm = 0;
};

void collect(const std::vector<Compared>& results, std::vector<double>& all,
             std::vector<double>& smooth) {
    for (const Compared& one : results) {
        if (!one.counts) continue;
        all.push_back(one.distance_mm);
        if (one.smooth) smooth.push_back(one.distance_mm);
    }
}

std::vector<Compared> mesh_against_truth(const TriMesh& mesh, const SculptureTruth& truth,
                                         const std::vector<TrueView>& views,
                                         const Rigid3& object_from_world,
                                         std::vector<float>& vertex_error_mm) {
    std::vector<Compared> results(mesh.positions.size());
    vertex_error_mm.assign(mesh.positions.size(), 0.0F);
    parallel_for_blocks(results.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto near = truth.nearest(object_from_world * mesh.positions[i]);
            vertex_error_mm[i] = static_cast<float>(near.distance_mm);
            results[i].distance_mm = near.distance_mm;
            results[i].counts = truth.is_seen(near.point, near.normal, views);
            results[i].smooth =
                results[i].counts && !near.relief && !truth.is_near_crease(near.point, kSmoothMm);
        }
    });
    return results;
}

std::vector<Compared> truth_against_mesh(const TriMesh& mesh, const SculptureTruth& truth,
                                         const std::vector<TrueView>& views,
                                         const Rigid3& object_from_world, unsigned seed,
                                         std::size_t& samples_taken) {
    const SurfaceTree tree(mesh);
    const Rigid3 world_from_object = object_from_world.inverse();
    const auto samples = truth.samples(100000, seed);
    samples_taken = samples.size();
    std::vector<Compared> results(samples.size());
    parallel_for_blocks(samples.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto& sample = samples[i];
            if (!truth.is_seen(sample.point, sample.normal, views)) continue;
            const auto hit = tree.nearest(world_from_object * sample.point);
            if (!hit) continue;
            results[i] = {true, !sample.relief && !truth.is_near_crease(sample.point, kSmoothMm),
                          hit->distance_mm};
        }
    });
    return results;
}

}  // namespace

ErrorFigures error_figures(std::vector<double> distances_mm) {
    ErrorFigures figures;
    figures.count = distances_mm.size();
    if (distances_mm.empty()) return figures;
    std::sort(distances_mm.begin(), distances_mm.end());
    double sum = 0, squares = 0;
    for (double d : distances_mm) {
        sum += d;
        squares += d * d;
    }
    const auto n = static_cast<double>(distances_mm.size());
    figures.mean_mm = sum / n;
    figures.rms_mm = std::sqrt(squares / n);
    figures.p95_mm = percentile(distances_mm, 0.95);
    figures.p99_mm = percentile(distances_mm, 0.99);
    figures.max_mm = distances_mm.back();
    return figures;
}

MeshTruth compare_with_truth(const TriMesh& measured, const SculptureTruth& truth,
                             const std::vector<TrueView>& views, const Rigid3& object_from_world,
                             unsigned seed) {
    MeshTruth result;
    result.object_from_world = fit_to_truth(truth, measured.positions, object_from_world);
    const auto there = mesh_against_truth(measured, truth, views, result.object_from_world,
                                          result.vertex_error_mm);
    std::size_t taken = 0;
    const auto back =
        truth_against_mesh(measured, truth, views, result.object_from_world, seed, taken);
    std::vector<double> all, smooth, one, other;
    collect(there, all, smooth);
    one = all;
    collect(back, all, smooth);
    other.assign(all.begin() + static_cast<std::ptrdiff_t>(one.size()), all.end());
    result.seen_share =
        taken > 0 ? static_cast<double>(other.size()) / static_cast<double>(taken) : 0;
    result.mesh_to_truth = error_figures(std::move(one));
    result.truth_to_mesh = error_figures(std::move(other));
    result.all = error_figures(std::move(all));
    result.smooth = error_figures(std::move(smooth));
    return result;
}

FilledTruth compare_filled_with_truth(const TriMesh& filled, const SculptureTruth& truth,
                                      const Rigid3& object_from_world) {
    FilledTruth result;
    result.vertex_error_mm.resize(filled.positions.size());
    parallel_for_blocks(filled.positions.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            result.vertex_error_mm[i] = static_cast<float>(
                truth.nearest(object_from_world * filled.positions[i]).distance_mm);
    });
    std::vector<double> distances;
    if (const VertexAttribute* attribute = filled.find_attribute("filled"))
        for (std::size_t i = 0; i < attribute->values.size(); ++i)
            if (attribute->values[i] > 0) distances.push_back(result.vertex_error_mm[i]);
    result.filled = error_figures(std::move(distances));
    return result;
}

SigmaTruth sigma_against_truth(const RangeImage& image, const SculptureTruth& truth,
                               const Rigid3& object_from_scan) {
    constexpr int kBorderCells = 3;
    const auto border = border_distance(image, range_triangles(image), kBorderCells + 1);
    const double crease_mm = kBorderCells * median_pitch_mm(image);
    std::vector<Vector3d> points;
    std::vector<std::size_t> cells;
    for (std::size_t i = 0; i < image.cell_count(); ++i) {
        if (!image.mask[i] || border[i] <= kBorderCells) continue;
        points.push_back(image.points[i].position);
        cells.push_back(i);
    }
    SigmaTruth result;
    const Rigid3 motion = fit_to_truth(truth, points, object_from_scan);
    result.object_from_scan = motion;
    std::vector<double> normalised(cells.size(), std::nan("")), errors = normalised,
                                                                sigmas = normalised;
    parallel_for_blocks(cells.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const RangePoint& point = image.points[cells[k]];
            const Vector3d at = motion * point.position;
            if (truth.is_near_crease(at, crease_mm)) continue;
            const Vector3d direction = motion.rotation * point.error_direction.cast<double>();
            const auto e = truth.error_along(at, direction, 2.0);
            const double sigma = std::hypot(point.sigma_mm, point.sigma_systematic_mm);
            if (!e || !(sigma > 0)) continue;
            normalised[k] = *e / sigma;
            errors[k] = std::abs(*e);
            sigmas[k] = sigma;
        }
    });
    const auto is_nan = [](double x) { return std::isnan(x); };
    std::erase_if(normalised, is_nan);
    std::erase_if(errors, is_nan);
    std::erase_if(sigmas, is_nan);
    result.points = normalised.size();
    const double middle = median(normalised);
    std::vector<double> deviations;
    for (double x : normalised) deviations.push_back(std::abs(x - middle));
    result.sigma_ratio = 1.4826 * median(std::move(deviations));
    result.median_sigma_mm = median(std::move(sigmas));
    result.median_error_mm = median(std::move(errors));
    for (std::size_t i = 0; i < normalised.size(); i += 20)
        result.normalised.push_back(normalised[i]);
    return result;
}

}  // namespace stria
