#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "sim/beam.h"
#include "sim/lit_patches.h"
#include "sim/scene_geometry.h"
#include "sim/stripe_light.h"

namespace stria {

/// Light that reaches a surface by way of another one, once, as the sheet sweeps: what each lit
/// piece scatters onto the surface (albedo / pi, and the glossy lobe where it has one), shadows
/// included. A pixel's light over s becomes Gaussians no narrower than the beam, finer near the
/// place where the sheet itself passes the surface. Sums over pieces no larger than a fifth of
/// their distance; nearer ones enter as parallelograms (form_factor.h).
class BounceLight {
  public:
    BounceLight(const Scene& scene, const Beam& beam, const SceneGeometry& geometry);

    /// Adds the lights of one pixel that looks at `hit` from `eye_in_world`.
    void add(const SurfaceHit& hit, const Eigen::Vector3d& eye_in_world, std::uint32_t pixel,
             std::vector<StripeLight>& lights) const;

    /// Irradiance (mW/mm^2 at power 1, summed over the sweep: times the unit of s) that the pieces
    /// throw on a surface. For tests.
    double dose(const SurfaceHit& hit) const;

  private:
    const Beam& beam_;
    const SceneGeometry& geometry_;
    LitPatches patches_;
    double s_low_ = 0, s_high_ = 0;
    double least_rate_ = 0;  ///< electrons a second
};

}  // namespace stria
