#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "sim/light_shape.h"
#include "sim/line_profile.h"
#include "sim/scene.h"
#include "sim/scene_geometry.h"

namespace stria {

/// How the sheet of light meets one surface point that one pixel looks at.
struct BeamAtPoint {
    /// Swept: the s at which the sheet's centre passes the point. Others: distance (mm) of the
    /// point from the sheet's centre at the s that was asked about.
    double position = 0;
    double per_position = 0;  ///< beam standard deviations per unit of position
    /// The same per unit of s, the pixel kept, not 0. Swept: positive. Others: signed, so that the
    /// distance in standard deviations is per_position * position + per_s * (change of s).
    double per_s = 0;
    bool is_near = true;  ///< per_s and rate are known
    double rate = 0;      ///< electrons a second from the beam's centre at power 1; 0: unlit
    Eigen::Vector3d light_in_world = Eigen::Vector3d::Zero();  ///< where the light comes from
    LightShape shape;  ///< plain unless LightParts::is_shaped
};

/// Camera and laser against the scene at one axis position.
struct HeadPose {
    Rigid3 world_from_camera, camera_from_world;
};
HeadPose head_pose(const Channel& channel, double s);

/// One ray of the sheet as it leaves the turning mirror. World frame.
struct BeamRay {
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();     ///< on the mirror
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit
    double mw_per_rad = 0;                                ///< of fan angle, at power 1
};

/// The laser of a scene: where it shines and how strongly a pixel sees it. Peak irradiance of the
/// sheet P / (fan r sqrt(2 pi) sigma) (a fan of even radiant intensity), reflection by Oren and
/// Nayar 1994 (their qualitative model), sensor by aperture, pixel, quantum efficiency.
///
/// Light in translucent material: of what falls on it the unpolarised Fresnel share T enters, of
/// that the share `subsurface` comes out about a point displaced by free_path_mm sin(refracted
/// angle) along the surface (L. Wang and S. Jacques, Applied Optics 34, 2362, 1995), as a Lambert
/// surface sends it. The surface counts as flat and evenly lit within a few free paths, but for
/// the sheet itself: light neither passes edges nor softens textures and shadows.
class Beam {
  public:
    /// @param order  0: the line; -1, +1: its ghosts (SceneLine::ghost)
    explicit Beam(const Scene& scene, int order = 0);

    /// For a swept machine: where in its travel the sheet passes the point. Newton steps from
    /// `guess`; empty if it passes outside the travel (half a travel to each side granted).
    std::optional<BeamAtPoint> passing(const SurfaceHit& hit, double guess) const;
    /// For a rail or table at one s: the sheet beside the point. per_s follows the pixel's ray as
    /// the surface, flat near the point, moves through it. Beyond `pixels` of the point's distance
    /// and 6 standard deviations and what the axis travels (`travel` units of s about it), only
    /// `position` and `per_position` are worked out and is_near is false.
    BeamAtPoint beside(const SurfaceHit& hit, const HeadPose& head, double travel = 0,
                       double pixels = 0) const;

    /// The same for a surface that sees the laser, and that the camera sees, in a plane mirror:
    /// `hit` is the surface's mirror image and `eye_in_world` the camera's.
    std::optional<BeamAtPoint> passing(const SurfaceHit& hit, double guess,
                                       const Eigen::Vector3d& eye_in_world) const;
    /// The sheet's ray at fan angle phi (rad) of a swept machine at s.
    BeamRay ray(double s, double phi) const;

    /// Electrons a second of a pixel that sees a white Lambert surface under 1 mW/mm^2.
    double electrons_per_mw_mm2() const { return electrons_per_irradiance_; }
    /// Electrons a second of a pixel that sees albedo 1 in ambient light.
    double ambient_rate() const { return ambient_rate_; }
    /// The channel, its sheet that of the order.
    const Channel& channel() const { return channel_; }
    const LightParts& parts() const { return parts_; }

  private:
    /// Standard deviation of the sheet (mm) at a point of the incoming sheet's frame, M^2 included.
    double width_at(const Eigen::Vector3d& point) const;
    /// @param across  unit, world: where the distance from the sheet grows
    LightShape shape_of(const SurfaceHit& hit, const BeamAtPoint& beam,
                        const Eigen::Vector3d& eye_in_world, const Eigen::Vector3d& across,
                        double sigma_mm, bool grows) const;

    double rate(const SurfaceHit& hit, const Rigid3& world_from_camera,
                const Eigen::Vector3d& eye_in_world, const Eigen::Vector3d& unfolded_in_camera,
                const Eigen::Vector3d& apex_in_camera, double sigma_mm) const;

    struct Material {
        double subsurface = 0, free_path_mm = 0, refractive_index = 1;
    };

    Channel channel_;
    LineProfile profile_;
    LightParts parts_;
    double m2_ = 1;
    std::vector<Material> materials_;  ///< by object; empty: none is translucent
    Eigen::Vector3d mirror_along_, mirror_cosine_, mirror_sine_;  ///< m(g) of the turning normal
    double middle_s_ = 0, half_travel_ = 0;
    double electrons_per_irradiance_ = 0;  ///< a second, for 1 mW/mm^2 on a white Lambert surface
    double laser_power_mw_ = 0;
    double ambient_rate_ = 0;
};

/// Share of the light (times pi) that a surface sends towards `to_eye`: albedo times oren_nayar
/// plus the glossy lobe. Unit vectors.
double reflected_share(const SurfaceHit& hit, const Eigen::Vector3d& to_light,
                       const Eigen::Vector3d& to_eye);

/// Share of the light (per steradian) in a glossy lobe of reflectance 1 at every angle: D G / (4
/// cos cos), D by Trowbridge and Reitz 1975 ("GGX"), G by Smith, uncorrelated (Walter and others
/// 2007, eqs. 33, 34, 23). 0 where light or eye are behind the surface. Unit vectors.
double glossy_lobe(const Eigen::Vector3d& normal, const Eigen::Vector3d& to_light,
                   const Eigen::Vector3d& to_eye, double alpha);

/// Share of unpolarised light that enters a smooth dielectric (Fresnel).
double fresnel_transmission(double cos_incidence, double refractive_index);

/// Share of the light (times pi) that a surface of slope deviation `roughness_rad` sends towards
/// `to_eye`; 1 for a Lambert surface. Unit vectors. Oren and Nayar 1994, their qualitative model.
double oren_nayar(const Eigen::Vector3d& normal, const Eigen::Vector3d& to_light,
                  const Eigen::Vector3d& to_eye, double roughness_rad);

}  // namespace stria
