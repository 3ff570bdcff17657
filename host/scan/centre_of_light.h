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
    Eigen::Vector2f sigma_px = Eigen::Vector2f::Zero();  ///< of the shift, by the pulses' noise
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
/// within two widths of the pulse, same laser and exposure, no warnings. A side without neighbours
/// leaves a one-sided difference, which falls short of the gradient at the end of a surface.
/// No shift exceeds 2 f.
/// @param chosen  the pulse of each cell, row-major; nullptr: none
std::vector<CentreOfLight> centres_of_light(std::span<const Pulse* const> chosen, int width,
                                            int height, double footprint_px);

/// The footprint that the pulses themselves show: the f^2 with which the bends of s from pixel to
/// pixel follow the bends that texture would draw (least squares; standard deviation from
/// eight bands of rows). Empty where texture is too weak to tell: f^2 below four of its
/// standard deviations, fewer than 1000 places, or f outside 0.2 to 3 px.
std::optional<PixelFootprint> estimate_footprint(std::span<const Pulse* const> chosen, int width,
                                                 int height);

}  // namespace stria
