#include "host/fusion/volume.h"

#include <cmath>

namespace stria {

std::int64_t SdfVolume::find(const Eigen::Vector3i& at) const {
    const auto found = slots_.find(brick_key(at));
    return found == slots_.end() ? -1 : static_cast<std::int64_t>(found->second);
}

std::uint32_t SdfVolume::find_or_add(const Eigen::Vector3i& at) {
    const auto [entry, added] =
        slots_.try_emplace(brick_key(at), static_cast<std::uint32_t>(bricks_.size()));
    if (added) {
        bricks_.emplace_back();
        bricks_.back().at = at;
    }
    return entry->second;
}

VoxelValue SdfVolume::voxel(const Eigen::Vector3i& at) const {
    const Eigen::Vector3i brick_at(at.x() >> 3, at.y() >> 3, at.z() >> 3);
    const VoxelValue empty = {.state = VoxelState::empty};
    const std::int64_t slot = find(brick_at);
    if (slot >= 0) {
        const Brick& b = bricks_[static_cast<std::size_t>(slot)];
        const int i = voxel_index(at.x() & 7, at.y() & 7, at.z() & 7);
        const auto at_i = static_cast<std::size_t>(i);
        if (b.sums && b.sums->weight[at_i] > 0) {
            const double weight = b.sums->weight[at_i];
            return {VoxelState::near_surface,
                    static_cast<double>(b.sums->weighted_distance[at_i]) / weight / kDistanceSteps *
                        voxel_mm_,
                    weight / kWeightSteps};
        }
        if (b.empty_bits[at_i >> 6] >> (at_i & 63) & 1) return empty;
    }
    if (carved_.contains(brick_at) && carved_.all_empty[carved_.index(brick_at)]) return empty;
    return {};
}

VoxelState SdfVolume::state_at(const Eigen::Vector3d& point) const {
    const Eigen::Vector3d scaled = point / voxel_mm_;
    const double limit = 8.0 * kMaxCoordinate;
    if (!(scaled.cwiseAbs().maxCoeff() < limit)) return VoxelState::unseen;
    return voxel(scaled.array().round().cast<int>().matrix()).state;
}

std::size_t SdfVolume::bytes_per_brick(bool with_sigmas) {
    constexpr std::size_t kDirectoryEntry = 48;  // hash node and its share of the table
    return sizeof(Brick) + sizeof(DistanceSums) + (with_sigmas ? sizeof(SigmaSums) : 0) +
           kDirectoryEntry;
}

std::size_t SdfVolume::memory_bytes() const {
    std::size_t bytes = carved_.all_empty.size();
    for (const Brick& b : bricks_)
        bytes += sizeof(Brick) + 48 + (b.sums ? sizeof(DistanceSums) : 0) +
                 (b.sigmas ? sizeof(SigmaSums) : 0);
    return bytes;
}

}  // namespace stria
