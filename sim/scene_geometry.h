#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>

#include "sim/scene.h"

namespace stria {

/// Where a ray first meets the scene. World frame, mm.
struct SurfaceHit {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();   ///< exact on its primitive, in double
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< unit, towards the ray's origin
    float albedo = 0;                                  ///< texture included; 0 for a mirror
    float roughness_rad = 0;
    float specular = 0, gloss = 1;  ///< SceneObject's
    int object = -1;                ///< index in scene.objects; -1: no hit
};

/// The objects of one view as something rays can be cast at (Embree finds the primitive in float;
/// the point on it is then computed in double). Const calls may run on any number of threads.
class SceneGeometry {
  public:
    explicit SceneGeometry(const Scene& scene);
    ~SceneGeometry();
    SceneGeometry(SceneGeometry&&) noexcept;
    SceneGeometry& operator=(SceneGeometry&&) noexcept;

    /// Moves the objects to where that view has them. 0 .. view_count(scene) - 1, else
    /// std::invalid_argument.
    void set_view(int view);

    /// First surface along the ray; object = -1 if none. `direction` need not be unit.
    SurfaceHit first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;
    /// The same for rays that leave one point; faster where neighbours run alike.
    void first_hits(const Eigen::Vector3d& origin, std::span<const Eigen::Vector3d> directions,
                    std::span<SurfaceHit> hits) const;
    /// True if something stands between a surface point and `to`. The segment starts a little
    /// above the surface (0.002 mm along the hit's normal on the side of `to`).
    bool is_occluded(const SurfaceHit& from, const Eigen::Vector3d& to) const;
    /// Where an object stands in the present view, and whether it is there at all.
    Rigid3 world_from_object(int object) const;
    bool is_visible(int object) const;
    /// The hit's point in the frame of its object, as the view places it.
    Eigen::Vector3d point_in_object(const SurfaceHit& hit) const;
    /// Signed error of a measured point along `direction` (unit) against the true surface: positive
    /// if the point lies beyond the surface, the nearest surface within reach_mm to either side.
    /// Empty if there is none.
    std::optional<double> error_along(const Eigen::Vector3d& point_in_world,
                                      const Eigen::Vector3d& direction,
                                      double reach_mm = 2.0) const;

  private:
    struct Content;
    std::unique_ptr<Content> content_;
};

}  // namespace stria
