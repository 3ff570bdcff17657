#pragma once
#include <vector>

#include "firmware/core/frame.h"

namespace stria::test {

/// A straight piece of a surface's cross-section, x0 < x1; lengths in pixels of the camera.
struct ProfileSegment {
    double x0, z0, x1, z1;
    double height_at(double x) const { return z0 + (z1 - z0) * (x - x0) / (x1 - x0); }
};

/// A cross-section (x, z) under a beam along -z that sweeps along x, seen by an orthographic camera
/// at `angle` from the beam: u = x cos(angle) - z sin(angle). Lambertian, direct light only; the
/// nearest surface along a line of sight is seen, the highest at x is lit. Noise-free; each row is
/// the same profile a quarter of a pixel further in the image.
struct LitProfile {
    std::vector<ProfileSegment> segments;
    double angle = 0.5235987755982988;  ///< rad, 30 degrees
    double beam_width = 6;              ///< sigma_b
    double footprint = 0.8;             ///< sigma_p on a surface that faces the beam
    double beam_step = 1.5;             ///< between frames
    double reach = 42;                  ///< the beam travels from -reach to reach

    static constexpr int kRows = 4, kWidth = 200;
    static constexpr double kHeight = 30000;  ///< DN of a fully lit surface that faces the beam

    int frames() const;
    double beam_at(double frame) const { return -reach + frame * beam_step; }
    double u_of(double column, int row) const { return column - 0.5 * kWidth + row / 4.0; }
    /// Height where the line of sight u crosses the sheet at x.
    double height_of(double x, double u) const;
    /// Distance of (x, z) from the nearest segment.
    double distance(double x, double z) const;
};

/// A symmetric corner of the given angle at x = 0, its tip up (roof) or down (valley), 90 px wide
/// on either side. @param ratio  sigma_p over sigma_b
LitProfile corner_profile(double degrees, bool roof, double ratio);
/// A strip six beam widths wide over a floor ten below.
LitProfile strip_profile(double ratio);

/// Where a method puts a point of the profile.
struct ProfilePoint {
    double x = 0, z = 0;
};

/// The light of a sweep over a profile, and where methods put the profile's points from it.
class ProfileSweep {
  public:
    explicit ProfileSweep(const LitProfile& profile);

    /// Centre of gravity of whole rows, for profiles with one stripe: where the sheet of the frame
    /// meets the line of sight; and of whole pixels over time: where the line of sight of the pixel
    /// meets the sheet of that time. Only where there is a tenth of the greatest light.
    std::vector<ProfilePoint> spatial_moments() const;
    std::vector<ProfilePoint> spacetime_moments() const;
    /// The same by find_peaks (centre of gravity) and by SpacetimeAnalyser; a stated SNR of 100.
    std::vector<ProfilePoint> spatial_peaks(int most_a_row) const;
    std::vector<ProfilePoint> spacetime_pulses() const;

  private:
    Frame frame(int k) const;
    LitProfile profile_;
    std::vector<std::vector<double>> light_;  ///< of frame, row after row, DN
};

}  // namespace stria::test
