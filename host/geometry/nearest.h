#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "host/core/tri_mesh.h"

namespace stria {

/// Nearest of a fixed set of points, by a k-d tree. Queries may run on many threads.
class PointTree {
  public:
    explicit PointTree(const std::vector<Eigen::Vector3d>& points);
    ~PointTree();
    PointTree(PointTree&&) noexcept;
    PointTree& operator=(PointTree&&) noexcept;

    struct Hit {
        std::uint32_t index;
        double distance_mm;
    };
    /// Nearest point within max_distance_mm; ties go to the lower index.
    std::optional<Hit> nearest(const Eigen::Vector3d& query, double max_distance_mm) const;
    /// Up to `count` nearest, nearest first.
    std::vector<Hit> nearest_few(const Eigen::Vector3d& query, int count) const;
    /// All within radius_mm, in ascending index order.
    std::vector<std::uint32_t> within(const Eigen::Vector3d& query, double radius_mm) const;

  private:
    struct Tree;
    std::unique_ptr<Tree> tree_;
};

/// Nearest point of a mesh's surface, by a bounding volume hierarchy. Borrows nothing: it copies
/// what it needs.
class SurfaceTree {
  public:
    explicit SurfaceTree(const TriMesh& mesh);
    ~SurfaceTree();
    SurfaceTree(SurfaceTree&&) noexcept;
    SurfaceTree& operator=(SurfaceTree&&) noexcept;

    struct Hit {
        std::uint32_t triangle;
        Eigen::Vector3d point;  ///< on the triangle
        Eigen::Vector3d barycentric;
        double distance_mm;
    };
    std::optional<Hit> nearest(const Eigen::Vector3d& query, double max_distance_mm = 1e300) const;

    struct RayHit {
        std::uint32_t triangle;
        double t;  ///< point = origin + t direction
        Eigen::Vector3d barycentric;
    };
    /// First triangle hit with t_min <= t <= t_max, either side.
    std::optional<RayHit> first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                    double t_min = 0, double t_max = 1e300) const;

  private:
    struct Tree;
    std::unique_ptr<Tree> tree_;
};

}  // namespace stria
