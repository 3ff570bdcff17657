#include "host/fusion/integrate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "host/core/errors.h"
#include "host/geometry/parallel.h"

namespace stria {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

/// Lines of sight longer than this many times the ramp are cut: seen at a flat angle, a place may
/// be close to the plane of the triangle and yet far along the line.
constexpr double kGrazingFactor = 2;

/// A triangle as the rasteriser needs it.
struct Facet {
    Vector3d corner[3];
    Vector3d station[3];  ///< camera of each corner; unused if orthographic
    Vector3d normal;      ///< unit, towards the camera
    double front_mm, tail_mm;
};

Facet make_facet(const RangeSurface& surface, std::size_t index, const RampLengths& ramp) {
    Facet facet;
    float sigma = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const SurfaceVertex& vertex = surface.vertices[surface.triangles[index][k]];
        facet.corner[k] = vertex.position;
        facet.station[k] = vertex.camera;
        sigma = std::max(sigma, vertex.sigma_mm);
    }
    facet.normal =
        (facet.corner[1] - facet.corner[0]).cross(facet.corner[2] - facet.corner[0]).normalized();
    const double three_sigma = 3 * static_cast<double>(sigma);
    facet.front_mm = ramp.front_mm + three_sigma;
    facet.tail_mm = std::max(ramp.tail_mm, ramp.tail_mm / 2 + three_sigma);
    return facet;
}

/// Closed box of voxels.
struct VoxelBox {
    Vector3i min, max;
};

/// Voxels that the facet's ramp can reach.
VoxelBox reach_of(const RangeSurface& surface, const Facet& facet, double voxel_mm) {
    Vector3d low = Vector3d::Constant(1e300), high = Vector3d::Constant(-1e300);
    for (int k = 0; k < 3; ++k) {
        const Vector3d view = surface.orthographic
                                  ? surface.towards_camera
                                  : (facet.station[k] - facet.corner[k]).normalized().eval();
        const double stretch = std::min(kGrazingFactor, 1 / std::max(0.01, view.dot(facet.normal)));
        for (const double along : {facet.front_mm * stretch, -facet.tail_mm * stretch}) {
            const Vector3d end = facet.corner[k] + along * view;
            low = low.cwiseMin(end);
            high = high.cwiseMax(end);
        }
    }
    const double limit = 8.0 * SdfVolume::kMaxCoordinate * voxel_mm;
    if (!(low.minCoeff() > -limit && high.maxCoeff() < limit))
        throw Error("fuse: a scan point lies farther than " + std::to_string(limit) +
                    " mm from the origin, which a voxel of " + std::to_string(voxel_mm) +
                    " mm cannot address; use a larger voxel, or move the scans nearer");
    return {(low / voxel_mm).array().floor().cast<int>().matrix(),
            (high / voxel_mm).array().ceil().cast<int>().matrix()};
}

/// The plane of sight through an edge, in coordinates of the brick. Both triangles of the edge
/// build it from the lower vertex number to the higher, so that their tests are opposite to the
/// last bit; a voxel exactly on it counts as moved by a fixed odd direction.
struct SightPlane {
    Vector3d normal;
    double offset;
    bool forwards;  ///< this triangle runs from the lower to the higher vertex
    bool tie_positive;

    double value(const Vector3d& p) const { return normal.dot(p) - offset; }
    bool inside(double value) const {
        const bool positive = value > 0 || (value == 0 && tie_positive);
        return positive == forwards;
    }
};

SightPlane sight_plane(const Vector3d& low, const Vector3d& high, const Vector3d& view,
                       bool forwards) {
    const Vector3d kOddDirection(1.0, 0.7548776662466927, 0.5698402909980532);
    SightPlane plane;
    plane.normal = view.cross(high - low);
    plane.offset = plane.normal.dot(low);
    plane.forwards = forwards;
    plane.tie_positive = plane.normal.dot(kOddDirection) > 0;
    return plane;
}

/// Puts the facets of one surface that touch one brick into its sums.
class BrickPainter {
  public:
    BrickPainter(const RangeSurface& surface, const RampLengths& ramp, double voxel_mm,
                 Brick& brick)
        : surface_(surface),
          ramp_(ramp),
          voxel_mm_(voxel_mm),
          brick_(brick),
          origin_(brick.at.cast<double>() * (kBrickSide * voxel_mm)) {}

    void paint(std::size_t index) {
        Facet facet = make_facet(surface_, index, ramp_);
        const VoxelBox reach = reach_of(surface_, facet, voxel_mm_);
        const Vector3i first = (reach.min - kBrickSide * brick_.at).cwiseMax(0);
        const Vector3i last = (reach.max - kBrickSide * brick_.at).cwiseMin(kBrickSide - 1);
        set_up(facet, index);
        for (int z = first.z(); z <= last.z(); ++z)
            for (int y = first.y(); y <= last.y(); ++y) paint_row(facet, first.x(), last.x(), y, z);
    }

  private:
    void set_up(Facet& facet, std::size_t index) {
        const auto& triangle = surface_.triangles[index];
        for (std::size_t k = 0; k < 3; ++k) {
            corner_[k] = &surface_.vertices[triangle[k]];
            facet.corner[k] -= origin_;
            facet.station[k] -= origin_;
        }
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t next = (k + 1) % 3;
            const bool forwards = triangle[k] < triangle[next];
            const std::size_t a = forwards ? k : next, b = forwards ? next : k;
            const Vector3d view =
                surface_.orthographic
                    ? surface_.towards_camera
                    : ((0.5 * (facet.station[a] + facet.station[b])) - facet.corner[a])
                          .normalized()
                          .eval();
            plane_[k] = sight_plane(facet.corner[a], facet.corner[b], view, forwards);
        }
        station_ = (facet.station[0] + facet.station[1] + facet.station[2]) / 3;
        height_ = facet.normal.dot(facet.corner[0]);
    }

    void paint_row(const Facet& facet, int x0, int x1, int y, int z) {
        Vector3d p(0, y * voxel_mm_, z * voxel_mm_);
        for (int x = x0; x <= x1; ++x) {
            p.x() = x * voxel_mm_;
            const double height = facet.normal.dot(p) - height_;  // along the normal
            if (height > facet.front_mm || height < -facet.tail_mm) continue;
            const double e0 = plane_[0].value(p);
            if (!plane_[0].inside(e0)) continue;
            const double e1 = plane_[1].value(p);
            if (!plane_[1].inside(e1)) continue;
            const double e2 = plane_[2].value(p);
            if (!plane_[2].inside(e2)) continue;
            add(facet, voxel_index(x, y, z), p, height, std::abs(e1), std::abs(e2), std::abs(e0));
        }
    }

    /// @param u, v, w  proportional to the barycentric coordinates of corners 0, 1, 2
    void add(const Facet& facet, int voxel, const Vector3d& p, double height, double u, double v,
             double w) {
        const Vector3d view =
            surface_.orthographic ? surface_.towards_camera : (station_ - p).normalized().eval();
        const double cosine = view.dot(facet.normal);
        const double sum = u + v + w;
        if (!(cosine > 0.01) || !(sum > 0)) return;
        const double distance = height / cosine;  // along the line of sight
        if (distance > kGrazingFactor * facet.front_mm ||
            distance < -kGrazingFactor * facet.tail_mm)
            return;
        const double depth =
            std::max(-height / facet.tail_mm, -distance / (kGrazingFactor * facet.tail_mm));
        const double ramp = depth <= 0.5 ? 1 : 2 * (1 - depth);
        const double share[3] = {u / sum, v / sum, w / sum};
        const auto mean = [&](float SurfaceVertex::*what) {
            return share[0] * static_cast<double>(corner_[0]->*what) +
                   share[1] * static_cast<double>(corner_[1]->*what) +
                   share[2] * static_cast<double>(corner_[2]->*what);
        };
        const double wanted = mean(&SurfaceVertex::weight) * ramp * kWeightSteps;
        const auto weight = std::max<std::int64_t>(1, std::llrint(wanted));
        const std::int64_t steps = std::llrint(distance / voxel_mm_ * kDistanceSteps);

        if (!brick_.sums) brick_.sums = std::make_unique<DistanceSums>();
        const auto i = static_cast<std::size_t>(voxel);
        brick_.sums->weighted_distance[i] += weight * steps;
        brick_.sums->weight[i] += static_cast<std::uint32_t>(weight);
        if (surface_.median_sigma_mm > 0)
            add_sigma(i, static_cast<std::uint64_t>(weight), mean(&SurfaceVertex::sigma_mm),
                      mean(&SurfaceVertex::systematic_mm));
    }

    void add_sigma(std::size_t i, std::uint64_t weight, double sigma_mm, double systematic_mm) {
        if (!brick_.sigmas) brick_.sigmas = std::make_unique<SigmaSums>();
        const auto steps = [&](double mm) {
            return static_cast<std::uint64_t>(
                std::llrint(std::min(mm / voxel_mm_, 16.0) * kSigmaSteps));
        };
        const std::uint64_t noise = weight * steps(sigma_mm) / 64;
        brick_.sigmas->noise[i] += noise * noise;
        brick_.sigmas->systematic[i] += weight * steps(systematic_mm);
    }

    const RangeSurface& surface_;
    const RampLengths& ramp_;
    double voxel_mm_;
    Brick& brick_;
    Vector3d origin_;
    const SurfaceVertex* corner_[3] = {};
    SightPlane plane_[3];
    Vector3d station_;
    double height_ = 0;
};

/// Which triangles touch which bricks, brick by brick.
struct BrickTriangles {
    std::vector<std::uint32_t> slots;  ///< bricks touched
    std::vector<std::size_t> begin;    ///< slots + 1 offsets into triangles
    std::vector<std::uint32_t> triangles;
};

[[noreturn]] void refuse_memory(double voxel_mm, std::size_t max_bytes) {
    throw Error("fuse: a volume of " + std::to_string(voxel_mm) +
                " mm voxels needs more than the " + std::to_string(max_bytes >> 20) +
                " MB allowed; use a larger voxel or more memory");
}

std::vector<VoxelBox> all_reaches(const RangeSurface& surface, const RampLengths& ramp,
                                  double voxel_mm) {
    std::vector<VoxelBox> bricks(surface.triangles.size());
    parallel_for_blocks(bricks.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const VoxelBox reach = reach_of(surface, make_facet(surface, i, ramp), voxel_mm);
            for (int k = 0; k < 3; ++k) {
                bricks[i].min[k] = reach.min[k] >> 3;
                bricks[i].max[k] = reach.max[k] >> 3;
            }
        }
    });
    return bricks;
}

BrickTriangles sort_by_brick(SdfVolume& volume, const RangeSurface& surface,
                             const RampLengths& ramp, std::size_t max_bytes) {
    const std::vector<VoxelBox> reach = all_reaches(surface, ramp, volume.voxel_mm());
    double pairs = 0;
    for (const VoxelBox& box : reach)
        pairs += (box.max - box.min + Vector3i::Ones()).cast<double>().prod();
    if (pairs * 8 > static_cast<double>(max_bytes)) refuse_memory(volume.voxel_mm(), max_bytes);

    const std::size_t per_brick = SdfVolume::bytes_per_brick(surface.median_sigma_mm > 0);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> slot_triangle;
    slot_triangle.reserve(static_cast<std::size_t>(pairs));
    std::size_t known = volume.bricks().size();
    std::uint64_t last_key = 0;
    std::uint32_t last_slot = 0;
    for (std::uint32_t i = 0; i < reach.size(); ++i)
        for (int z = reach[i].min.z(); z <= reach[i].max.z(); ++z)
            for (int y = reach[i].min.y(); y <= reach[i].max.y(); ++y)
                for (int x = reach[i].min.x(); x <= reach[i].max.x(); ++x) {
                    const std::uint64_t key = brick_key(x, y, z) + 1;
                    if (key != last_key) last_slot = volume.find_or_add({x, y, z});
                    last_key = key;
                    slot_triangle.emplace_back(last_slot, i);
                    if (volume.bricks().size() > known) {
                        known = volume.bricks().size();
                        if (known * per_brick > max_bytes)
                            refuse_memory(volume.voxel_mm(), max_bytes);
                    }
                }

    std::vector<std::size_t> count(volume.bricks().size() + 1, 0);
    for (const auto& pair : slot_triangle) ++count[pair.first + 1];
    BrickTriangles sorted;
    for (std::uint32_t slot = 0; slot + 1 < count.size(); ++slot) {
        if (count[slot + 1] > 0) {
            sorted.slots.push_back(slot);
            sorted.begin.push_back(count[slot]);
        }
        count[slot + 1] += count[slot];
    }
    sorted.begin.push_back(slot_triangle.size());
    sorted.triangles.resize(slot_triangle.size());
    for (const auto& [slot, triangle] : slot_triangle) sorted.triangles[count[slot]++] = triangle;
    return sorted;
}

}  // namespace

void integrate(SdfVolume& volume, const RangeSurface& surface, const RampLengths& ramp,
               std::size_t max_bytes) {
    const BrickTriangles work = sort_by_brick(volume, surface, ramp, max_bytes);
    parallel_for_blocks(work.slots.size(), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            BrickPainter painter(surface, ramp, volume.voxel_mm(), volume.brick(work.slots[i]));
            for (std::size_t k = work.begin[i]; k < work.begin[i + 1]; ++k)
                painter.paint(work.triangles[k]);
        }
    });
}

}  // namespace stria
