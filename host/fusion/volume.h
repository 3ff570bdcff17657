#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

namespace stria {

/// What is known about a place: no line of sight came here; one passed through; or a measured
/// surface is close by and the signed distance says where.
enum class VoxelState : std::uint8_t { unseen, empty, near_surface };

constexpr int kBrickSide = 8;
constexpr int kBrickVoxels = kBrickSide * kBrickSide * kBrickSide;
/// Integers in the sums: one voxel of distance, and the weight 1.
constexpr double kDistanceSteps = 32768;
constexpr double kWeightSteps = 4095;
constexpr double kSigmaSteps = 4096;  ///< sigma / voxel 1

/// Sums over all contributions to each voxel. Integers, so that neither the order of scans nor the
/// number of threads changes a bit.
struct DistanceSums {
    std::array<std::int64_t, kBrickVoxels> weighted_distance{};  ///< sum of w d
    std::array<std::uint32_t, kBrickVoxels> weight{};            ///< sum of w; 0: none came near
};

/// Sums for the standard deviation of the mean, kept where scans know theirs.
struct SigmaSums {
    std::array<std::uint64_t, kBrickVoxels> noise{};       ///< sum of (w sigma)^2
    std::array<std::uint64_t, kBrickVoxels> systematic{};  ///< sum of w sigma_systematic
};

/// 8 x 8 x 8 voxels; voxel (x, y, z) at x + 8 y + 64 z.
struct Brick {
    Eigen::Vector3i at = Eigen::Vector3i::Zero();  ///< voxel (0, 0, 0) is voxel 8 at of the volume
    std::unique_ptr<DistanceSums> sums;            ///< none: no surface near
    std::unique_ptr<SigmaSums> sigmas;
    std::array<std::uint64_t, 8> empty_bits{};  ///< carved voxels, one word a z layer
};

/// Box of bricks, and for each whether all its voxels are empty (1).
struct CarvedBox {
    Eigen::Vector3i min = Eigen::Vector3i::Zero();
    Eigen::Vector3i size = Eigen::Vector3i::Zero();  ///< 0: nothing was carved
    std::vector<std::uint8_t> all_empty;

    bool contains(const Eigen::Vector3i& brick) const {
        return ((brick - min).array() >= 0).all() && ((brick - min).array() < size.array()).all();
    }
    std::size_t index(const Eigen::Vector3i& brick) const {
        const Eigen::Vector3i d = brick - min;
        return (static_cast<std::size_t>(d.z()) * static_cast<std::size_t>(size.y()) +
                static_cast<std::size_t>(d.y())) *
                   static_cast<std::size_t>(size.x()) +
               static_cast<std::size_t>(d.x());
    }
};

/// What one voxel holds. Distance in mm, positive in front of the surface.
struct VoxelValue {
    VoxelState state = VoxelState::unseen;
    double distance_mm = 0;
    double weight = 0;
};

/// A sparse signed distance volume in the world frame: voxel (i, j, k) lies at voxel_mm (i, j, k).
/// Source of the field and its states: Curless & Levoy 1996, sections 3 and 4.
class SdfVolume {
  public:
    explicit SdfVolume(double voxel_mm) : voxel_mm_(voxel_mm) {}

    double voxel_mm() const { return voxel_mm_; }
    const std::vector<Brick>& bricks() const { return bricks_; }
    Brick& brick(std::uint32_t slot) { return bricks_[slot]; }
    const CarvedBox& carved() const { return carved_; }
    void set_carved(CarvedBox box) { carved_ = std::move(box); }

    /// Slot of a brick, or -1.
    std::int64_t find(const Eigen::Vector3i& at) const;
    /// Slot of a brick, made if there is none.
    std::uint32_t find_or_add(const Eigen::Vector3i& at);

    VoxelValue voxel(const Eigen::Vector3i& at) const;
    /// State of the voxel nearest to a point (mm, world frame).
    VoxelState state_at(const Eigen::Vector3d& point) const;

    /// Bytes held, and the bytes one brick with sums takes.
    std::size_t memory_bytes() const;
    static std::size_t bytes_per_brick(bool with_sigmas);
    /// Largest |brick coordinate| that a key can hold.
    static constexpr int kMaxCoordinate = (1 << 20) - 2;

  private:
    double voxel_mm_;
    std::vector<Brick> bricks_;
    std::unordered_map<std::uint64_t, std::uint32_t> slots_;
    CarvedBox carved_;
};

/// A number for a brick, ascending in z, y, x.
constexpr std::uint64_t brick_key(int x, int y, int z) {
    constexpr int kMiddle = 1 << 20;
    return (static_cast<std::uint64_t>(z + kMiddle) << 42) |
           (static_cast<std::uint64_t>(y + kMiddle) << 21) |
           static_cast<std::uint64_t>(x + kMiddle);
}
inline std::uint64_t brick_key(const Eigen::Vector3i& at) {
    return brick_key(at.x(), at.y(), at.z());
}

inline int voxel_index(int x, int y, int z) { return x + kBrickSide * (y + kBrickSide * z); }

}  // namespace stria
