#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/beam.h"
#include "sim/pixel_cells.h"
#include "sim/scene.h"
#include "sim/scene_geometry.h"
#include "sim/stripe_light.h"
#include "sim/surface_speckle.h"

namespace stria {

/// Turns a scene into the light of every pixel. One ray a pixel; where neighbours tell of an edge,
/// a shadow, a crease or a texture's border, the pixel is cut into cells and along the border
/// (pixel_cells.h) where SceneSensor::cut_edges asks, or seen by 16 rays. Where the surface is
/// smooth the pixel's footprint is cut into parts no longer than half a beam width, each with its
/// variance added to the beam's. With a lens that blurs every pixel also gets the spot of the depth
/// at its centre.
class ViewLight {
  public:
    /// @param seed  of the speckle that sticks to surfaces
    ViewLight(const Scene& scene, const SceneGeometry& geometry, std::uint64_t seed,
              const PixelSampling& sampling = {});

    /// Swept machine: all light of a whole sweep, in bands of rows.
    std::vector<LightBlock> whole_sweep() const;
    /// Swept machine: what comes by way of other surfaces (Scene::reflection) in the same bands;
    /// empty where the scene asks for none. Bounced light by one ray a pixel, the mirrors' by 16.
    std::vector<LightBlock> reflected_sweep(const Scene& scene) const;
    /// Rail or table: light while s is within +- travel / 2 of `s`.
    std::vector<LightBlock> around(double s, double travel) const;

  private:
    struct Moment;
    struct Picture;
    struct PixelRays;
    PixelRays rays_in(int x, int y, const HeadPose& head) const;
    std::vector<LightBlock> collect(Moment moment) const;
    void collect_line(const Moment& moment, std::vector<LightBlock>& blocks) const;
    RayLight judge(const SurfaceHit& hit, const Moment& moment, double guess,
                   LightShape& shape) const;
    void first_rays(const Moment& moment, int row, Picture& picture) const;
    bool is_uneven(const std::vector<RayLight>& image, int x, int y) const;
    void add_smooth(const Picture& picture, int x, int y, const Moment& moment,
                    LightBlock& block) const;
    void add_uneven(const std::vector<RayLight>& image, int x, int y, const Moment& moment,
                    LightBlock& block) const;
    void emit(const RayLight& seen, const LightShape& shape, double share, double footprint2,
              std::uint32_t pixel, const Moment& moment, LightBlock& block) const;

    const SceneGeometry& geometry_;
    std::vector<Beam> beams_;  ///< the line, then its ghosts
    PixelSampling sampling_;
    std::optional<SurfaceSpeckle> speckle_;
    bool is_swept_;
    Scene optics_;  ///< without objects and views; lens and camera decide the spots
    bool is_blurred_;
    int width_, height_;
    std::vector<Eigen::Vector3d> rays_;  ///< of pixel centres, camera frame
};

}  // namespace stria
