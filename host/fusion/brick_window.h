#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "host/fusion/closing_body.h"
#include "host/fusion/volume.h"

namespace stria {

/// The voxels of one brick and of one layer all round it. The corners of its 8^3 cells are those
/// with coordinates 0 to 8; the others are their neighbours.
struct BrickWindow {
    static constexpr int kSide = kBrickSide + 3;
    static constexpr std::size_t kCount = kSide * kSide * kSide;
    std::array<float, kCount> value;  ///< signed distance / voxel; unseen -1, empty +1
    std::array<VoxelState, kCount> state;
    std::array<float, kCount> sigma_mm;  ///< where near and known, else 0
    /// Not near, yet all its neighbours that are near lie on the same side: then so does it, though
    /// its distance is not known; `value` has that sign.
    std::array<std::uint8_t, kCount> side_known;

    /// @param x, y, z  -1 to 9
    static std::size_t index(int x, int y, int z) {
        return static_cast<std::size_t>((x + 1) + kSide * ((y + 1) + kSide * (z + 1)));
    }
};

/// Reads the volume as the iso-surface sees it. With `fill`, unseen space outside the closing body
/// is empty.
class WindowReader {
  public:
    WindowReader(const SdfVolume& volume, const ClosingBody& body, bool fill)
        : volume_(volume), body_(body), fill_(fill) {}

    /// What all voxels of a brick are, or near_surface if they may differ.
    VoxelState uniform_state(const Eigen::Vector3i& brick) const;
    /// The window round a brick. Without `fill` it also says which sides are known.
    void read(const Eigen::Vector3i& brick, BrickWindow& window) const;

  private:
    void read_part(const Eigen::Vector3i& brick, const Eigen::Vector3i& first,
                   const Eigen::Vector3i& last, const Eigen::Vector3i& shift,
                   BrickWindow& window) const;
    VoxelState beyond_sums(const Eigen::Vector3i& brick, const Brick* content, int body_part,
                           VoxelState uniform, const Eigen::Vector3i& local) const;
    void find_sides(BrickWindow& window) const;
    int body_part(const Eigen::Vector3i& brick) const;

    const SdfVolume& volume_;
    const ClosingBody& body_;
    bool fill_;
};

}  // namespace stria
