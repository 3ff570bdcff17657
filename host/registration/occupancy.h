#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace stria {

/// Says quickly where there is certainly no point near: bits over coarse cells of several sizes,
/// set where a cell or one of its 26 neighbours holds a point.
class OccupancyGrid {
  public:
    OccupancyGrid() = default;
    /// @param finest_mm  side of the finest level's cells; each further level's are twice as large
    OccupancyGrid(const std::vector<Eigen::Vector3d>& points, double finest_mm);

    /// False only if no point lies within distance_mm of `query`.
    bool may_be_near(const Eigen::Vector3d& query, double distance_mm) const;

  private:
    struct Level {
        double cell_mm = 0;
        Eigen::Vector3d low = Eigen::Vector3d::Zero();
        std::array<std::int64_t, 3> size{};
        std::vector<std::uint64_t> bits;
    };
    std::vector<Level> levels_;  ///< fine to coarse
};

}  // namespace stria
