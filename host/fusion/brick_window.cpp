#include "host/fusion/brick_window.h"

#include <algorithm>
#include <cmath>

namespace stria {
namespace {

float sigma_of_mean(const SigmaSums& sums, std::size_t i, double weight, double voxel_mm) {
    const double noise = 64 * std::sqrt(static_cast<double>(sums.noise[i])) / weight;
    const double systematic = static_cast<double>(sums.systematic[i]) / weight;
    return static_cast<float>(std::hypot(noise, systematic) / kSigmaSteps * voxel_mm);
}

}  // namespace

int WindowReader::body_part(const Eigen::Vector3i& brick) const {
    const double h = volume_.voxel_mm();
    const Eigen::Vector3d centre =
        (brick.cast<double>() * kBrickSide + Eigen::Vector3d::Constant(3.5)) * h;
    return body_.holds(centre, 3.5 * std::sqrt(3.0) * h);
}

VoxelState WindowReader::uniform_state(const Eigen::Vector3i& brick) const {
    if (volume_.find(brick) >= 0) return VoxelState::near_surface;
    const CarvedBox& box = volume_.carved();
    if (box.contains(brick) && box.all_empty[box.index(brick)]) return VoxelState::empty;
    if (!fill_) return VoxelState::unseen;
    const int part = body_part(brick);
    return part == 0   ? VoxelState::empty
           : part == 1 ? VoxelState::near_surface
                       : VoxelState::unseen;
}

VoxelState WindowReader::beyond_sums(const Eigen::Vector3i& brick, const Brick* content,
                                     int body_part, VoxelState uniform,
                                     const Eigen::Vector3i& local) const {
    if (uniform == VoxelState::empty) return uniform;
    if (content && content->empty_bits[static_cast<std::size_t>(local.z())] >>
                           (local.x() + kBrickSide * local.y()) &
                       1)
        return VoxelState::empty;
    if (!fill_ || body_part == 2) return VoxelState::unseen;
    if (body_part == 0) return VoxelState::empty;
    const Eigen::Vector3d point = (kBrickSide * brick + local).cast<double>() * volume_.voxel_mm();
    return body_.holds(point, 0) == 0 ? VoxelState::empty : VoxelState::unseen;
}

void WindowReader::read_part(const Eigen::Vector3i& brick, const Eigen::Vector3i& first,
                             const Eigen::Vector3i& last, const Eigen::Vector3i& shift,
                             BrickWindow& window) const {
    const std::int64_t slot = volume_.find(brick);
    const Brick* content = slot >= 0 ? &volume_.bricks()[static_cast<std::size_t>(slot)] : nullptr;
    const CarvedBox& box = volume_.carved();
    const VoxelState uniform = box.contains(brick) && box.all_empty[box.index(brick)]
                                   ? VoxelState::empty
                                   : VoxelState::unseen;
    const int part = fill_ ? body_part(brick) : 2;
    for (int z = first.z(); z <= last.z(); ++z)
        for (int y = first.y(); y <= last.y(); ++y)
            for (int x = first.x(); x <= last.x(); ++x) {
                const std::size_t to =
                    BrickWindow::index(x + shift.x(), y + shift.y(), z + shift.z());
                const auto i = static_cast<std::size_t>(voxel_index(x, y, z));
                window.sigma_mm[to] = 0;
                if (content && content->sums && content->sums->weight[i] > 0) {
                    const double weight = content->sums->weight[i];
                    window.state[to] = VoxelState::near_surface;
                    window.value[to] = static_cast<float>(
                        static_cast<double>(content->sums->weighted_distance[i]) / weight /
                        kDistanceSteps);
                    if (content->sigmas)
                        window.sigma_mm[to] =
                            sigma_of_mean(*content->sigmas, i, weight, volume_.voxel_mm());
                    continue;
                }
                window.state[to] = beyond_sums(brick, content, part, uniform, {x, y, z});
                window.value[to] = window.state[to] == VoxelState::empty ? 1.0f : -1.0f;
            }
}

void WindowReader::read(const Eigen::Vector3i& brick, BrickWindow& window) const {
    for (int part = 0; part < 27; ++part) {
        const Eigen::Array3i step(part % 3 - 1, part / 3 % 3 - 1, part / 9 - 1);
        const Eigen::Array3i first = (step < 0).select(7, Eigen::Array3i::Zero());
        const Eigen::Array3i last = (step > 0).select(1, Eigen::Array3i::Constant(7));
        read_part(brick + step.matrix(), first, last, kBrickSide * step, window);
    }
    window.side_known.fill(0);
    if (!fill_) find_sides(window);
}

void WindowReader::find_sides(BrickWindow& window) const {
    constexpr auto kRow = static_cast<std::size_t>(BrickWindow::kSide);
    constexpr std::size_t kSteps[3] = {1, kRow, kRow * kRow};
    for (int z = 0; z <= kBrickSide; ++z)
        for (int y = 0; y <= kBrickSide; ++y)
            for (int x = 0; x <= kBrickSide; ++x) {
                const std::size_t i = BrickWindow::index(x, y, z);
                if (window.state[i] == VoxelState::near_surface) continue;
                int inside = 0, outside = 0;
                for (const std::size_t step : kSteps)
                    for (const std::size_t n : {i - step, i + step})
                        if (window.state[n] == VoxelState::near_surface)
                            ++(window.value[n] < 0 ? inside : outside);
                if ((inside > 0) == (outside > 0)) continue;
                window.side_known[i] = 1;
                window.value[i] = inside > 0 ? -1.0f : 1.0f;
            }
}

}  // namespace stria
