#pragma once
#include <optional>
#include <string>
#include <vector>

#include "firmware/core/sensor_noise.h"
#include "host/advise/crossing.h"
#include "host/core/scanner_model.h"

/// What advice is given about: a scanner as a plain struct, built, or designed from wishes.
namespace stria {

/// The camera beyond its geometry. Defaults: a global-shutter camera of 3.45 um pixels.
struct SensorSpec {
    double pixel_um = 3.45;
    double f_number = 5.6;
    double full_well_e = 10500;
    double read_noise_e = 2.5;
    int bits = 10;
    /// Electrons per DN; without it, the full well fills the converter.
    std::optional<double> gain_e_per_dn;
    double black_dn = 0;              ///< DN of no light
    double quantum_efficiency = 0.5;  ///< electrons per photon at the laser's wavelength
    double aberration_px = 0.3;       ///< standard deviation of the lens's own blur
    /// True: no diffraction, defocus or aberration, only the pixel's own size. What a simulated
    /// camera does; no real one.
    bool perfect_lens = false;
    double frame_period_us = 16700;  ///< shortest
    /// Without it, what brings the brightest surface to 80 % of full scale, at most a frame period.
    std::optional<double> exposure_us;
};

/// Electrons per DN, the default worked out.
double gain_e_per_dn(const SensorSpec& sensor);
/// DN at which a sample clips: converter or full well.
double full_scale_dn(const SensorSpec& sensor);
SensorNoise noise_of(const SensorSpec& sensor);

/// A camera by name; its figures are of one measured specimen or of its sensor's family.
struct NamedCamera {
    std::string name;
    std::string about;  ///< with the source of the figures
    int width = 0, height = 0;
    SensorSpec sensor;
};
const std::vector<NamedCamera>& named_cameras();
/// Throws std::invalid_argument listing the names if there is none of that name.
const NamedCamera& named_camera(const std::string& name);

/// What stands before the scanner.
struct SurfaceSpec {
    double albedo = 0.8;            ///< 0..1, diffuse
    double brightest_albedo = 0.9;  ///< must not saturate; at least `albedo`
    /// Angle of the laser's light to the surface's normal; without it the surface faces the camera.
    std::optional<double> incidence_rad;
    double reflectance_ratio = 10;  ///< of the paint's edges
    double hole_width_mm = 10;      ///< of the slots that should be seen into
    double speckle_contrast = 1;    ///< before the pixel: 1 coherent and polarised, 0 incoherent
    double ambient_level = 0;       ///< share of full scale on albedo 1
};

/// A scanner that is there, or has been designed.
struct AdvisedScanner {
    Channel channel;
    SensorSpec sensor;
    double power_mw = 5;  ///< in the sheet, spread evenly over the fan
    double m_squared = 1;
    double near_mm = 0, middle_mm = 0, far_mm = 0;  ///< depths along the camera's axis
    double focus_mm = 0;                            ///< sharp distance
    SurfaceSpec surface;
    std::optional<double> step;       ///< unit of s; without it the advised one
    double axis_sigma = 0;            ///< standard deviation of a logged position, unit of s
    std::optional<AxisRange> travel;  ///< of the axis, where it is known
};

/// Empty if advice can be given, else the field, its value and its bound.
std::string validate(const AdvisedScanner& scanner);
std::string validate(const SensorSpec& sensor);
std::string validate(const SurfaceSpec& surface);

/// "NAME = VALUE: expected BOUND".
std::string wrong_value(const std::string& name, double value, const std::string& bound);

}  // namespace stria
