#pragma once
#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "firmware/core/pulse.h"

namespace stria {

/// What a pixel sees of the scene, lens and pixel together, as a Gaussian.
struct PixelFootprint {
    double sigma_px = 0;           ///< standard deviation; 0: a point
    double sigma_of_sigma_px = 0;  ///< of the estimate
};

/// Where in and about its pixel the light of a pulse came from.
struct CentreOfLight {
    Eigen::Vector2f shift_px = Eigen::Vector2f::Zero();  ///< from the pixel's middle
    Eigen::Vector2f sigma_px = Eigen::Vector2f::Zero();  ///< of the shift
    bool is_partly_lit = false;                          ///< on the border of a surface or shadow
};

/// Centres of light of the pulses of a swept spacetime map. A pulse over time is timed by the
/// middle of the light that its pixel sees, not by the pixel's middle: beside an edge of
/// reflectance, on a speckled or a partly covered pixel the two differ. Where the footprint is a
/// Gaussian of standard deviation f, the middle is exactly f^2 grad ln E away, with E the pulse's
/// light (amplitude x width) as the image of neighbouring pixels has it (Robbins 1956 and Efron
/// 2011 of the mean of a Gaussian mixture, "Tweedie's formula"; Yue, Dantanarayana, Wu and Huntley,
/// Opt. Lasers Eng. 112, 2019, meet the same error in fringe projection).
///
/// The gradient comes from up to two neighbours on either side that continue the surface: their s
/// within two widths of the pulse, same laser and exposure, no warnings. A side without any leaves
/// a one-sided difference. No shift exceeds 2 f.
///
/// Where a surface ends (two pixels on one side without a pulse or with one more than two widths
/// away; on the other it goes on) and the pixel is darker than the four inwards lead to expect, by
/// three standard deviations of the noise and of the steps between those, the border of surface or
/// shadow runs through it. With the share L of its light left, the
/// middle of that light is sqrt(3) f (1 - L) inwards: exact for a border along the pixel's side and
/// a footprint that is the pixel's square alone (f = 1 / sqrt(12), taken where f is not known),
/// within 9 % for a Gaussian down to L = 0.2. Its sigma is the noise's and a quarter of the shift:
/// the border may run aslant, and the surface may be darker there.
/// @param chosen  the pulse of each cell, row-major; nullptr: none
/// @param footprint_px  f; 0: not known, only what is partly lit moves
std::vector<CentreOfLight> centres_of_light(std::span<const Pulse* const> chosen, int width,
                                            int height, double footprint_px);

/// The footprint that the pulses themselves show: the f^2 with which the bends of s from pixel to
/// pixel follow the bends that texture would draw (least squares; standard deviation from
/// eight bands of rows). Empty where texture is too weak to tell: f^2 below four of its
/// standard deviations, fewer than 1000 places, or f outside 0.2 to 3 px.
std::optional<PixelFootprint> estimate_footprint(std::span<const Pulse* const> chosen, int width,
                                                 int height);

}  // namespace stria
