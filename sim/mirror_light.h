#pragma once
#include <Eigen/Core>
#include <vector>

#include "sim/beam.h"
#include "sim/scene_geometry.h"
#include "sim/stripe_light.h"

namespace stria {

/// The sheet as plane mirrors of the scene throw it on other surfaces, reflected once: a mirror's
/// share of the light is its object's albedo. What the camera sees in a mirror is not followed.
class MirrorLight {
  public:
    MirrorLight(const Scene& scene, const Beam& beam, const SceneGeometry& geometry);

    /// Adds the lights of `share` of one pixel that looks at `hit` from `eye_in_world`.
    void add(const SurfaceHit& hit, const Eigen::Vector3d& eye_in_world, double share,
             std::uint32_t pixel, std::vector<StripeLight>& lights) const;

  private:
    struct Mirror {
        Rigid3 object_from_world;
        Eigen::Vector3d normal, point;  ///< world
        Eigen::Vector2d low, high;      ///< of the rectangle, object frame, mm
        double share = 1;
    };
    const Beam& beam_;
    const SceneGeometry& geometry_;
    std::vector<Mirror> mirrors_;
    double middle_s_ = 0;
};

}  // namespace stria
