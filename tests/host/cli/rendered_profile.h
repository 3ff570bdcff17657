#pragma once
#include <string>
#include <vector>

#include "host/link/recording_contents.h"
#include "sim/scene.h"

/// Cards, corners and strips before a swept stripe, rendered by the simulator without noise, and
/// where methods put their points. Lengths in mm. A profile's own frame: X along the sweep, Z up
/// from the surface; edges cross the rows a little slanted, at every phase; the camera's pixel is
/// 0.25 mm, laser and camera stand 30 degrees apart.
namespace stria::test_support {

/// A straight piece of the cross-section, x0 < x1.
struct SurfacePiece {
    double x0 = 0, z0 = 0, x1 = 0, z1 = 0;
    double height_at(double x) const { return z0 + (z1 - z0) * (x - x0) / (x1 - x0); }
};

struct RenderedProfile {
    Scene scene;
    ScanPlan plan;  ///< record = frames
    std::vector<SurfacePiece> pieces;
    Eigen::Matrix3d scan_from_profile;  ///< columns X, Y, Z; the origin is kMiddle
    double beam_mm = 0;                 ///< sigma_b, on a surface square to Z
    double footprint_mm = 0;            ///< sigma_p, likewise
    double pitch_mm = 0;                ///< of the sweep's frames, along X
};

/// A card that faces the camera, reflectance contrast : 1, its edge at X = 0.
/// @param beam_mm  sigma_b across the beam
RenderedProfile rendered_card(double contrast, double beam_mm, double psf_sigma_px);
/// A symmetric corner about the beam, its tip up (roof) or down. @param ratio  sigma_p / sigma_b
RenderedProfile rendered_corner(double degrees, bool roof, double ratio);
/// A strip 4 mm wide over a floor ten beam widths below it, square to the beam, sigma_b a sixth of
/// its width.
RenderedProfile rendered_strip(double ratio);

struct ProfilePoint {
    double x = 0, z = 0;
};

/// Where each method puts the points of a profile.
struct LocatedProfile {
    std::vector<ProfilePoint> row_moments;    ///< centre of gravity of whole rows
    std::vector<ProfilePoint> peaks;          ///< find_peaks, centre of gravity
    std::vector<ProfilePoint> pixel_moments;  ///< centre of gravity of whole pixels over time
    std::vector<ProfilePoint> pulses;         ///< spacetime, maximum likelihood
    std::vector<ProfilePoint> centred;        ///< those, moved to their centres of light
    int greatest_dn = 0;                      ///< of 65535
};

/// Renders the sweep and analyses it all five ways. @param most_a_row  peaks
LocatedProfile located(const RenderedProfile& profile, int most_a_row = 1);

/// Greatest height error within that distance from X = 0, over sigma_b.
double greatest_error(const RenderedProfile& profile, const std::vector<ProfilePoint>& points,
                      double within_mm);

/// Edge curl: how much of the sweep has a point more than a tenth of sigma_b from the surface.
struct Curl {
    double length = 0;  ///< over sigma_b, mean of the rows
    double worst = 0;   ///< greatest distance over sigma_b
};
/// @param pitch_mm  of the points along X
Curl curl_of(const RenderedProfile& profile, const std::vector<ProfilePoint>& points,
             double pitch_mm);

constexpr int kProfileRows = 8;
constexpr double kPixelMm = 0.25;

}  // namespace stria::test_support
