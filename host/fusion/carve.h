#pragma once
#include <cstddef>
#include <vector>

#include "host/fusion/sight_buffer.h"
#include "host/fusion/volume.h"

namespace stria {

/// The views of one scan along which space is seen to be free: from its camera, and from its laser
/// unless it is orthographic. A station that moves is cut into pieces, each short enough that a
/// ray seen from the piece's middle is off by at most `tolerance_mm` over `reach_mm` in front of
/// the surface; neighbouring pieces overlap by half, so that no seam stays unseen.
/// @param open  quads that the camera sees through, see background_quads
std::vector<SightBuffer> sight_buffers(const RangeSurface& surface, double ramp_mm, double pixel_mm,
                                       double tolerance_mm, double reach_mm,
                                       const std::vector<std::array<Eigen::Vector3d, 4>>& open);

/// Marks as empty what scans saw to be free, within the box of the bricks near surfaces and one
/// more brick all round: tile by tile (8^3 bricks), from coarse boxes to bricks to voxels. Where a
/// surface is near, it stays near. The order of scans and views does not matter. Source: Curless &
/// Levoy 1996, section 4; hierarchy by depth pyramid: Greene et al. 1993.
class Carver {
  public:
    /// Throws stria::Error if the box would need more than max_bytes.
    Carver(const SdfVolume& volume, std::size_t max_bytes);
    ~Carver();
    Carver(const Carver&) = delete;
    Carver& operator=(const Carver&) = delete;

    double box_diagonal_mm() const;
    void carve(const std::vector<SightBuffer>& buffers);
    /// Writes the result into the volume.
    void store(SdfVolume& volume) const;

  private:
    struct Tile;
    double voxel_mm_;
    std::size_t max_bytes_;
    CarvedBox box_;
    Eigen::Vector3i tiles_ = Eigen::Vector3i::Zero();
    std::vector<Tile> tile_;
};

}  // namespace stria
