#pragma once

/// What a surface's shape and paint do to a triangulating scanner, whatever its noise: edges of
/// reflectance, and what camera and laser cannot both see.
namespace stria {

/// Greatest shift of a Gaussian's centre of gravity, in its standard deviations, by a step of
/// reflectance 1 : `ratio` under it: max over d of
/// (1 - 1/K) phi(d) / [Phi(d) + (1 - Phi(d)) / K]. accuracy.md A.1, error source 1.
double reflectance_step_shift(double ratio);

/// Errors in depth (mm) at a reflectance step on a surface that faces the camera, one triangulation
/// angle away from the laser. accuracy.md A.1 and finding 6.
struct EdgeError {
    double spatial_mm = 0;    ///< centre of gravity of the stripe, sigma_b / cos(angle) wide there
    double spacetime_mm = 0;  ///< centre of gravity over time: a footprint sigma_p wide
    double ratio = 0;         ///< the second over the first
};
EdgeError edge_error(double reflectance_ratio, double sigma_p_mm, double sigma_b_mm,
                     double triangulation_rad);

/// What both see, far from the part against its size. Closed forms of two directions `angle` apart.
struct Occlusion {
    double hemisphere_share = 0;  ///< of the half of a sphere that faces the camera: 1 - angle/pi
    double steepest_wall_rad =
        0;  ///< tilt, away from the laser, of a plane still lit: pi/2 - angle
    double hole_depth_per_width = 0;  ///< slot facing the camera, its floor's middle still lit
    /// The same with the slot turned half-way between camera and laser; part of the floor seen.
    double best_hole_depth_per_width = 0;
};
/// The slot runs along the stripe, the worst way. Facing the camera its lit part of the floor is
/// w - d tan(angle), which holds the middle while d <= w / (2 tan(angle)); half-way it is
/// w - 2 d tan(angle / 2).
Occlusion occlusion_of(double triangulation_rad);

}  // namespace stria
