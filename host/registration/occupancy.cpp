#include "host/registration/occupancy.h"

#include <algorithm>
#include <cmath>

namespace stria {
namespace {

constexpr int kLevels = 5;
/// Finer levels than this many cells are left out: 16 MB of bits.
constexpr std::int64_t kMaxCells = std::int64_t{1} << 27;

}  // namespace

OccupancyGrid::OccupancyGrid(const std::vector<Eigen::Vector3d>& points, double finest_mm) {
    if (points.empty() || !(finest_mm > 0)) return;
    Eigen::Vector3d low = points.front(), high = low;
    for (const Eigen::Vector3d& point : points) {
        low = low.cwiseMin(point);
        high = high.cwiseMax(point);
    }
    for (int k = 0; k < kLevels; ++k) {
        Level level;
        level.cell_mm = finest_mm * std::pow(2.0, k);
        level.low = low.array() - 1.5 * level.cell_mm;  // a rim of cells to spread into
        double cells = 1;
        for (int axis = 0; axis < 3; ++axis) {
            const double count = std::floor((high - level.low)[axis] / level.cell_mm) + 2;
            cells *= count;
            level.size[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(count);
        }
        if (!(cells < static_cast<double>(kMaxCells))) continue;
        level.bits.assign(static_cast<std::size_t>(cells) / 64 + 1, 0);
        const auto set = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
            const auto at = static_cast<std::size_t>((z * level.size[1] + y) * level.size[0] + x);
            level.bits[at / 64] |= std::uint64_t{1} << (at % 64);
        };
        std::int64_t last = -1;  // neighbours in the list mostly share a cell
        for (const Eigen::Vector3d& point : points) {
            const Eigen::Vector3d at = (point - level.low) / level.cell_mm;
            const auto x = static_cast<std::int64_t>(at.x()), y = static_cast<std::int64_t>(at.y()),
                       z = static_cast<std::int64_t>(at.z());
            const std::int64_t cell = (z * level.size[1] + y) * level.size[0] + x;
            if (cell == last) continue;
            last = cell;
            for (std::int64_t w = z - 1; w <= z + 1; ++w)
                for (std::int64_t v = y - 1; v <= y + 1; ++v)
                    for (std::int64_t u = x - 1; u <= x + 1; ++u) set(u, v, w);
        }
        levels_.push_back(std::move(level));
    }
}

bool OccupancyGrid::may_be_near(const Eigen::Vector3d& query, double distance_mm) const {
    const auto level = std::find_if(levels_.begin(), levels_.end(), [&](const Level& candidate) {
        return candidate.cell_mm >= distance_mm;
    });
    if (level == levels_.end()) return true;
    const Eigen::Vector3d at = (query - level->low) / level->cell_mm;
    for (int axis = 0; axis < 3; ++axis)
        if (!(at[axis] >= 0) ||
            !(at[axis] < static_cast<double>(level->size[static_cast<std::size_t>(axis)])))
            return false;
    const auto bit = static_cast<std::size_t>(
        (static_cast<std::int64_t>(at.z()) * level->size[1] + static_cast<std::int64_t>(at.y())) *
            level->size[0] +
        static_cast<std::int64_t>(at.x()));
    return (level->bits[bit / 64] >> (bit % 64) & 1) != 0;
}

}  // namespace stria
