#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/beam.h"
#include "sim/scene.h"
#include "sim/scene_geometry.h"
#include "sim/stripe_light.h"
#include "sim/surface_speckle.h"

namespace stria {

/// What one ray through a pixel says about its light.
struct RayLight {
    double position = 0;  ///< BeamAtPoint::position
    float per_position = 0;
    float per_s = 0;
    float rate = 0;     ///< electrons a second at the beam's centre; 0 if dark or in shadow
    float ambient = 0;  ///< electrons a second
    float speckle = 1;  ///< factor of rate, not yet in it
    std::int16_t object = -1;
    bool judged = false;     ///< the beam is near enough for rate to be known
    std::uint16_t spot = 0;  ///< SpotSpread's index for its depth
};

/// Turns a scene into the light of every pixel. One ray a pixel; where neighbours tell of an edge,
/// a shadow, a crease or a texture's border, 16 rays in strata (each column and each row of the
/// pixel's sixteenths holds one). Where the surface is smooth the pixel's footprint is cut into
/// parts no longer than half a beam width, each with its variance added to the beam's. With a lens
/// that blurs every pixel also gets the spot of the depth at its centre.
class ViewLight {
  public:
    /// @param seed  of the speckle that sticks to surfaces
    ViewLight(const Scene& scene, const SceneGeometry& geometry, std::uint64_t seed);

    /// Swept machine: all light of a whole sweep, in bands of rows.
    std::vector<LightBlock> whole_sweep() const;
    /// Swept machine: what comes by way of other surfaces (Scene::reflection) in the same bands;
    /// empty where the scene asks for none. Bounced light by one ray a pixel, the mirrors' by 16.
    std::vector<LightBlock> reflected_sweep(const Scene& scene) const;
    /// Rail or table: light while s is within +- travel / 2 of `s`.
    std::vector<LightBlock> around(double s, double travel) const;

  private:
    struct Moment;
    struct Rays;
    Rays rays_in(int x, int y, const HeadPose& head) const;
    std::vector<LightBlock> collect(const Moment& moment) const;
    RayLight judge(const SurfaceHit& hit, const Moment& moment, double guess) const;
    void first_rays(const Moment& moment, int row, RayLight* lights) const;
    bool is_uneven(const std::vector<RayLight>& image, int x, int y) const;
    void add_smooth(const std::vector<RayLight>& image, int x, int y, const Moment& moment,
                    LightBlock& block) const;
    void add_uneven(int x, int y, const Moment& moment, double guess, LightBlock& block) const;

    const SceneGeometry& geometry_;
    Beam beam_;
    std::optional<SurfaceSpeckle> speckle_;
    bool is_swept_;
    Scene optics_;  ///< without objects and views; lens and camera decide the spots
    bool is_blurred_;
    int width_, height_;
    std::vector<Eigen::Vector3d> rays_;  ///< of pixel centres, camera frame
};

}  // namespace stria
