#include "host/fusion/integrate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "host/core/errors.h"
#include "host/geometry/parallel.h"

namespace stria {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

/// Stretch of a row, cut by half-planes; a little too long, never too short.
struct Clip {
    double low, high;

    /// Keeps value + slope x >= 0.
    void keep(double value, double slope) {
        if (std::abs(slope) < 1e-9) return;
        const double at = -value / slope;
        if (slope > 0)
            low = std::max(low, at);
        else
            high = std::min(high, at);
    }
};

/// Puts the facets of one surface that touch one brick into its sums.
class BrickPainter {
  public:
    BrickPainter(const RangeSurface& surface, double voxel_mm, Brick& brick)
        : surface_(surface), voxel_mm_(voxel_mm), brick_(brick) {}

    void paint(const Facet& facet, const std::array<std::uint32_t, 3>& triangle) {
        for (std::size_t k = 0; k < 3; ++k) corner_[k] = &surface_.vertices[triangle[k]];
        const Vector3i origin = kBrickSide * brick_.at;
        const Vector3i first = facet.reach.min.cwiseMax(origin);
        const Vector3i last = facet.reach.max.cwiseMin(origin + Vector3i::Constant(kBrickSide - 1));
        for (int z = first.z(); z <= last.z(); ++z)
            for (int y = first.y(); y <= last.y(); ++y) paint_row(facet, first.x(), last.x(), y, z);
    }

  private:
    void paint_row(const Facet& facet, int x0, int x1, int y, int z) {
        Vector3d p(0, y * voxel_mm_, z * voxel_mm_);
        const double row_height =
            facet.normal.y() * p.y() + facet.normal.z() * p.z() - facet.height;
        double row[3];
        Clip clip = {x0 * voxel_mm_, x1 * voxel_mm_};
        clip.keep(row_height + facet.tail_mm, facet.normal.x());
        clip.keep(facet.front_mm - row_height, -facet.normal.x());
        for (std::size_t k = 0; k < 3; ++k) {
            row[k] = facet.plane[k].row(p.y(), p.z());
            const double sign = facet.plane[k].forwards ? 1 : -1;
            clip.keep(sign * row[k], sign * facet.plane[k].normal.x());
        }
        if (clip.low > clip.high + voxel_mm_) return;
        x0 = std::max(x0, static_cast<int>(std::ceil(clip.low / voxel_mm_ - 1e-6)));
        x1 = std::min(x1, static_cast<int>(std::floor(clip.high / voxel_mm_ + 1e-6)));
        for (int x = x0; x <= x1; ++x) {
            p.x() = x * voxel_mm_;
            const double height = row_height + facet.normal.x() * p.x();  // along the normal
            if (height > facet.front_mm || height < -facet.tail_mm) continue;
            double e[3];
            bool inside = true;
            for (std::size_t k = 0; k < 3 && inside; ++k) {
                e[k] = facet.plane[k].at(row[k], p.x());
                inside = facet.plane[k].inside(e[k]);
            }
            if (inside)
                add(facet, voxel_index(x & 7, y & 7, z & 7), p, height, std::abs(e[1]),
                    std::abs(e[2]), std::abs(e[0]));
        }
    }

    /// @param u, v, w  proportional to the barycentric coordinates of corners 0, 1, 2
    void add(const Facet& facet, int voxel, const Vector3d& p, double height, double u, double v,
             double w) {
        const Vector3d view = surface_.orthographic ? surface_.towards_camera
                                                    : (facet.station - p).normalized().eval();
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
    double voxel_mm_;
    Brick& brick_;
    const SurfaceVertex* corner_[3] = {};
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

/// First and last brick that a box of voxels touches.
VoxelBox bricks_of(const VoxelBox& voxels) {
    VoxelBox bricks;
    for (int k = 0; k < 3; ++k) {
        bricks.min[k] = voxels.min[k] >> 3;
        bricks.max[k] = voxels.max[k] >> 3;
    }
    return bricks;
}

double count_pairs(const std::vector<Facet>& facets) {
    double pairs = 0;
    for (const Facet& facet : facets) {
        const VoxelBox bricks = bricks_of(facet.reach);
        pairs += (bricks.max - bricks.min + Vector3i::Ones()).cast<double>().prod();
    }
    return pairs;
}

/// Makes the bricks on the way.
BrickTriangles sort_by_brick(SdfVolume& volume, const std::vector<Facet>& facets, bool with_sigmas,
                             std::size_t max_bytes) {
    const double h = volume.voxel_mm(), half_side = 3.5 * h;
    if (count_pairs(facets) * 8 > static_cast<double>(max_bytes)) refuse_memory(h, max_bytes);
    const std::size_t most_bricks = max_bytes / SdfVolume::bytes_per_brick(with_sigmas);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> slot_triangle;
    slot_triangle.reserve(2 * facets.size());
    std::uint64_t last_key = 0;
    std::uint32_t last_slot = 0;
    for (std::uint32_t i = 0; i < facets.size(); ++i) {
        const VoxelBox bricks = bricks_of(facets[i].reach);
        for (int z = bricks.min.z(); z <= bricks.max.z(); ++z)
            for (int y = bricks.min.y(); y <= bricks.max.y(); ++y)
                for (int x = bricks.min.x(); x <= bricks.max.x(); ++x) {
                    const Vector3d middle =
                        h * (kBrickSide * Vector3d(x, y, z) + Vector3d::Constant(3.5));
                    if (!facets[i].may_touch(middle, half_side)) continue;
                    const std::uint64_t key = brick_key(x, y, z) + 1;
                    if (key != last_key) last_slot = volume.find_or_add({x, y, z});
                    last_key = key;
                    slot_triangle.emplace_back(last_slot, i);
                }
        if (volume.bricks().size() > most_bricks) refuse_memory(h, max_bytes);
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
    const std::vector<Facet> facets = make_facets(surface, ramp, volume.voxel_mm());
    const BrickTriangles work =
        sort_by_brick(volume, facets, surface.median_sigma_mm > 0, max_bytes);
    parallel_for_blocks(work.slots.size(), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            BrickPainter painter(surface, volume.voxel_mm(), volume.brick(work.slots[i]));
            for (std::size_t k = work.begin[i]; k < work.begin[i + 1]; ++k)
                painter.paint(facets[work.triangles[k]], surface.triangles[work.triangles[k]]);
        }
    });
}

}  // namespace stria
