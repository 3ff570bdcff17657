#pragma once
#include <string>
#include <vector>

#include "firmware/core/pulse.h"
#include "host/advise/crossing.h"
#include "host/advise/lens.h"
#include "host/advise/scanner.h"
#include "host/advise/surface_limits.h"

namespace stria {

/// Random error of one method at one place, one standard deviation, mm. `x` is across the camera's
/// axis where the beam stands, `z` along it. accuracy.md A.4: sigma_z = sigma_x / tan(angle).
struct MethodSigma {
    double position = 0;    ///< bound of the pulse's position: frames, or px of the stripe
    double x_mm = 0;        ///< from camera noise, where the beam stood over the surface
    double noise_z_mm = 0;  ///< camera noise and the axis log
    double speckle_z_mm = 0;
    double z_mm = 0;  ///< both, in quadrature
    bool speckle_dominates() const { return speckle_z_mm > noise_z_mm; }
};

/// The scanner at one place, for `near`, `middle` and `far` of an Advice on the camera's axis
/// (swept) or on the sheet in the middle row (rail, turntable).
struct DepthAdvice {
    double depth_mm = 0;
    Crossing crossing;
    double pixel_mm = 0;  ///< side of a pixel on a surface that faces the camera
    Footprint footprint;
    double sigma_b_mm = 0;        ///< beam, standard deviation across it
    double incidence_rad = 0;     ///< of the light on the surface
    double peak_e = 0;            ///< electrons of the brightest sample over time
    double peak_dn = 0;           ///< with ambient light and black level
    double snr = 0;               ///< of that sample
    double frames_per_sigma = 0;  ///< of the beam, at the step used; infinite where nothing moves
    double greatest_step = 0;     ///< that moves the sheet by sigma_b; infinite where nothing moves
    bool saturated = false;
    double speckle_mm = 0;             ///< size on the object, lambda / (2 sin u)
    double contrast = 0;               ///< of speckle after the pixel
    double wavefront_mm = 0;           ///< radius of the beam's wavefront
    double effective_distance_mm = 0;  ///< D_eff of accuracy.md finding 5
    MethodSigma spacetime, spatial;
    EdgeError edge;  ///< at the surface's reflectance_ratio
};

/// One way to place the beam's waist, at the middle depth. accuracy.md finding 5.
struct WaistChoice {
    std::string name;  ///< "as stated", "at the mirror", "on the object"
    double waist_sigma_mm = 0;
    double sigma_b_mm = 0, wavefront_mm = 0, effective_distance_mm = 0;
    double speckle_x_mm = 0;  ///< frozen part and boiling part in quadrature
};

struct Advice {
    MachineKind kind = MachineKind::swept;
    Lens lens;
    double field_width_mm = 0, field_height_mm = 0;  ///< at the middle depth
    double baseline_mm = 0;     ///< from camera to laser line (at the pivot on a swept machine)
    double fan_needed_rad = 0;  ///< to light the whole field at every depth
    double exposure_us = 0;
    double greatest_step = 0;  ///< unit of s: the stripe's width, the narrowest anywhere
    double advised_step = 0;   ///< half of it: two frames a sigma (accuracy.md A.1)
    double step = 0;           ///< the one the figures are for
    AxisRange range;
    double frames = 0, seconds = 0;           ///< of one sweep at `step`
    StripeMode mode = StripeMode::spacetime;  ///< how devices scan: swept over time
    DepthAdvice near, middle, far;
    DepthAdvice worst;  ///< of the field's corners, edges and middle at the three depths
    std::vector<WaistChoice> waists;
    Occlusion occlusion;                ///< in the middle
    std::vector<std::string> warnings;  ///< what contradicts itself or will not work, for people

    const MethodSigma& method(const DepthAdvice& at) const {
        return mode == StripeMode::spacetime ? at.spacetime : at.spatial;
    }
    double worst_z_mm() const;  ///< of the mode, over the three depths
};

/// What to expect of a scanner. Throws std::invalid_argument where validate() complains, and
/// stria::Error where the sheet does not pass the stated depths, and where a stated step exceeds
/// the stripe's width: the message names step, width and the step to take.
Advice advise(const AdvisedScanner& scanner);

}  // namespace stria
