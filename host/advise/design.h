#pragma once
#include <optional>
#include <string>

#include "host/advise/advise.h"

namespace stria {

/// What a person wishes for and has at hand, before anything is built. The defaults already make a
/// whole scanner.
struct ScannerDesign {
    MachineKind kind = MachineKind::swept;
    double width_mm = 200;     ///< field of view across the camera's image, at `distance_mm`
    double distance_mm = 400;  ///< camera to the middle of the depth
    double depth_mm = 80;      ///< from the nearest to the farthest surface
    int width_px = 1456, height_px = 1088;
    SensorSpec sensor;
    double wavelength_nm = 650;
    double power_mw = 5;
    double m_squared = 1.2;
    /// Without it: as wide on the object as spacetime wants, four footprints (finding 6), if the
    /// beam can be.
    std::optional<double> waist_sigma_mm;
    /// From the mirror (swept) or the laser (else) along the beam; without it at the mirror, or
    /// (rail, turntable: nothing turns the wavefront) on the object.
    std::optional<double> waist_at_mm;
    std::optional<double> fan_rad;      ///< without it what the field's height needs
    double laser_to_mirror_mm = 50;     ///< swept
    std::optional<double> baseline_mm;  ///< camera to mirror (swept) or laser
    std::optional<double> sigma_z_mm;   ///< wanted, over the whole depth
    SurfaceSpec surface;
    std::optional<double> step;  ///< unit of s
    double axis_sigma = 0;       ///< unit of s
};

/// Empty if a scanner can be made of it, else the field, its value and its bound.
std::string validate(const ScannerDesign& design);

/// The scanner of a design with that baseline: camera at the origin along z, pivot or laser at
/// (baseline, 0, 0), its sheet through (0, 0, distance) at s = 0. The table's axis stands at the
/// far end of the depth.
AdvisedScanner scanner_of(const ScannerDesign& design, double baseline_mm);

/// Advice on a design, and the scanner it is about.
struct DesignAdvice {
    AdvisedScanner scanner;
    Advice advice;
    bool baseline_chosen = false;
    /// Least baseline that reaches the wanted sigma_z over the whole depth; empty: none asked for,
    /// or none up to an angle of 60 deg does.
    std::optional<double> baseline_for_sigma_mm;
    double best_sigma_z_mm = 0;  ///< worst over the depth at 60 deg; with a wanted sigma_z only
};

/// With a baseline: what it gives. Without: the least baseline that reaches the wanted sigma_z, or
/// where none is wanted that of a triangulation angle of 25 deg. Throws as advise() does.
DesignAdvice advise_design(const ScannerDesign& design);

}  // namespace stria
