#include "host/fusion/carve.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>

#include "host/core/errors.h"
#include "host/geometry/parallel.h"

namespace stria {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr int kTileSide = 8;  ///< bricks
constexpr int kTileBricks = kTileSide * kTileSide * kTileSide;
constexpr std::size_t kMaxPieces = 512;
using Bits = std::array<std::uint64_t, 8>;

/// Numbers of all triangles; the laser may not have passed between those that are no surface.
std::vector<std::uint32_t> all_triangles(const RangeSurface& surface, bool laser) {
    std::vector<std::uint32_t> all(laser ? surface.first_gap : surface.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

/// Triangles in ascending s, cut where the eye has moved too far.
std::vector<std::vector<std::uint32_t>> pieces_of(const RangeSurface& surface, bool laser,
                                                  double longest_mm) {
    const auto eye = [&](std::uint32_t t) {
        const SurfaceVertex& v = surface.vertices[surface.triangles[t][0]];
        return laser ? v.laser : v.camera;
    };
    const auto s = [&](std::uint32_t t) { return surface.vertices[surface.triangles[t][0]].s; };
    std::vector<std::uint32_t> order = all_triangles(surface, laser);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return s(a) != s(b) ? s(a) < s(b) : a < b; });
    double path = 0;
    for (std::size_t i = 1; i < order.size(); ++i)
        path += (eye(order[i]) - eye(order[i - 1])).norm();
    longest_mm = std::max(longest_mm, path / kMaxPieces);

    std::vector<std::size_t> begin = {0};
    for (std::size_t i = 1; i < order.size(); ++i)
        if ((eye(order[i]) - eye(order[begin.back()])).norm() > longest_mm) begin.push_back(i);
    begin.push_back(order.size());
    std::vector<std::vector<std::uint32_t>> pieces;
    for (std::size_t k = 0; k + 1 < begin.size(); ++k) {
        const std::size_t half = (begin[k + 1] - begin[k]) / 2;
        const std::size_t from = begin[k] - std::min(begin[k], half);
        const std::size_t to = std::min(order.size(), begin[k + 1] + half);
        pieces.emplace_back(order.begin() + static_cast<std::ptrdiff_t>(from),
                            order.begin() + static_cast<std::ptrdiff_t>(to));
    }
    return pieces;
}

double nearest_mm(const RangeSurface& surface, bool laser) {
    double nearest = 1e300;
    for (const SurfaceVertex& v : surface.vertices)
        nearest = std::min(nearest, (v.position - (laser ? v.laser : v.camera)).norm());
    return nearest;
}

}  // namespace

std::vector<SightBuffer> sight_buffers(const RangeSurface& surface, double ramp_mm, double pixel_mm,
                                       double tolerance_mm, double reach_mm,
                                       const std::vector<std::array<Vector3d, 4>>& open) {
    struct Piece {
        bool laser;
        std::vector<std::uint32_t> triangles;
    };
    std::vector<Piece> pieces;
    for (const bool laser : {false, true}) {
        if (surface.triangles.empty() || (laser && surface.orthographic)) break;
        if (laser ? surface.laser_moves : surface.camera_moves) {
            const double half = tolerance_mm * nearest_mm(surface, laser) / reach_mm;
            for (auto& triangles : pieces_of(surface, laser, 2 * half))
                pieces.push_back({laser, std::move(triangles)});
        } else {
            pieces.push_back({laser, all_triangles(surface, laser)});
        }
    }
    std::vector<std::optional<SightBuffer>> made(pieces.size());
    parallel_for_blocks(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            made[i].emplace(surface, pieces[i].triangles, pieces[i].laser, ramp_mm, pixel_mm,
                            pieces[i].laser ? std::vector<std::array<Vector3d, 4>>{} : open);
    });
    std::vector<SightBuffer> buffers;
    for (auto& buffer : made) buffers.push_back(std::move(*buffer));
    return buffers;
}

/// States of 8^3 bricks, and voxel bits of those that are neither all unseen nor all empty.
struct Carver::Tile {
    Vector3i first = Vector3i::Zero();                ///< brick
    std::array<std::int16_t, kTileBricks> bits_of{};  ///< 0: all unseen, -1: all empty, else 1 + i
    std::vector<Bits> bits;
    int empty_bricks = 0;

    static std::size_t index(const Vector3i& local) {
        return static_cast<std::size_t>(local.x() +
                                        kTileSide * (local.y() + kTileSide * local.z()));
    }

    void empty_all(const Vector3i& local) {
        std::int16_t& state = bits_of[index(local)];
        empty_bricks += state != -1;
        state = -1;
    }

    void add_bits(const Vector3i& local, const Bits& seen) {
        std::int16_t& state = bits_of[index(local)];
        if (state == -1) return;
        Bits all = seen;
        if (state > 0)
            for (std::size_t z = 0; z < 8; ++z)
                all[z] |= bits[static_cast<std::size_t>(state - 1)][z];
        bool none = true, full = true;
        for (const std::uint64_t layer : all) {
            none &= layer == 0;
            full &= layer == ~std::uint64_t{0};
        }
        if (none) return;
        if (full) return empty_all(local);
        if (state == 0) {
            bits.emplace_back();
            state = static_cast<std::int16_t>(bits.size());
        }
        bits[static_cast<std::size_t>(state - 1)] = all;
    }

    void carve(const SightBuffer& buffer, double voxel_mm, const Vector3i& local, int side) {
        const Vector3d low = ((first + local) * kBrickSide).cast<double>() * voxel_mm;
        const Vector3d high = low + Vector3d::Constant((side * kBrickSide - 1) * voxel_mm);
        if (side == 1 && bits_of[index(local)] == -1) return;
        const SightBuffer::Answer answer = buffer.sees_box(low, high);
        if (answer == SightBuffer::Answer::none) return;
        if (answer == SightBuffer::Answer::some && side == 1) {
            Bits seen{};
            buffer.sees_voxels(low, voxel_mm, seen.data());
            return add_bits(local, seen);
        }
        const int half = answer == SightBuffer::Answer::all ? 1 : side / 2;
        for (int z = 0; z < side; z += half)
            for (int y = 0; y < side; y += half)
                for (int x = 0; x < side; x += half) {
                    const Vector3i part = local + Vector3i(x, y, z);
                    if (answer == SightBuffer::Answer::all)
                        empty_all(part);
                    else
                        carve(buffer, voxel_mm, part, half);
                }
    }
};

Carver::~Carver() = default;

Carver::Carver(const SdfVolume& volume, std::size_t max_bytes)
    : voxel_mm_(volume.voxel_mm()), max_bytes_(max_bytes) {
    Vector3i low = Vector3i::Constant(1 << 30), high = -low;
    for (const Brick& brick : volume.bricks()) {
        if (!brick.sums) continue;
        low = low.cwiseMin(brick.at);
        high = high.cwiseMax(brick.at);
    }
    if (low.x() > high.x()) return;
    box_.min = low - Vector3i::Ones();
    box_.size = high - low + Vector3i::Constant(3);
    tiles_ = ((box_.size + Vector3i::Constant(kTileSide - 1)) / kTileSide).eval();
    const double bricks = box_.size.cast<double>().prod();
    if (bricks * 4 > static_cast<double>(max_bytes)) {
        const Vector3d mm = box_.size.cast<double>() * (kBrickSide * voxel_mm_);
        throw Error("fuse: carving a box of " + std::to_string(mm.x()) + " x " +
                    std::to_string(mm.y()) + " x " + std::to_string(mm.z()) + " mm at " +
                    std::to_string(voxel_mm_) + " mm needs more than the " +
                    std::to_string(max_bytes >> 20) +
                    " MB allowed; use a larger voxel or more memory, or do not carve");
    }
    box_.all_empty.assign(static_cast<std::size_t>(bricks), 0);
    tile_.resize(static_cast<std::size_t>(tiles_.cast<double>().prod()));
    std::size_t i = 0;
    for (int z = 0; z < tiles_.z(); ++z)
        for (int y = 0; y < tiles_.y(); ++y)
            for (int x = 0; x < tiles_.x(); ++x)
                tile_[i++].first = box_.min + kTileSide * Vector3i(x, y, z);
}

double Carver::box_diagonal_mm() const {
    return box_.size.cast<double>().norm() * kBrickSide * voxel_mm_;
}

void Carver::carve(const std::vector<SightBuffer>& buffers) {
    parallel_for_blocks(tile_.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            for (const SightBuffer& buffer : buffers) {
                if (tile_[i].empty_bricks == kTileBricks) break;
                tile_[i].carve(buffer, voxel_mm_, Vector3i::Zero(), kTileSide);
            }
    });
    std::size_t bytes = box_.all_empty.size() + tile_.size() * sizeof(Tile);
    for (const Tile& tile : tile_) bytes += tile.bits.size() * (sizeof(Bits) + 48);
    if (bytes > max_bytes_)
        throw Error("fuse: carving at " + std::to_string(voxel_mm_) + " mm needs more than the " +
                    std::to_string(max_bytes_ >> 20) +
                    " MB allowed; use a larger voxel or more memory, or do not carve");
}

void Carver::store(SdfVolume& volume) const {
    CarvedBox box = box_;
    for (const Tile& tile : tile_)
        for (int i = 0; i < kTileBricks; ++i) {
            const Vector3i at = tile.first + Vector3i(i % kTileSide, i / kTileSide % kTileSide,
                                                      i / (kTileSide * kTileSide));
            const int state = tile.bits_of[static_cast<std::size_t>(i)];
            if (state == 0 || !box.contains(at)) continue;
            if (state < 0)
                box.all_empty[box.index(at)] = 1;
            else
                volume.brick(volume.find_or_add(at)).empty_bits =
                    tile.bits[static_cast<std::size_t>(state - 1)];
        }
    volume.set_carved(std::move(box));
}

}  // namespace stria
