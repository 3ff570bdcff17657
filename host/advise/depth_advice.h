#pragma once
#include "host/advise/advise.h"
#include "host/advise/gaussian_beam.h"

namespace stria {

/// The parts of the advice at one place that do not depend on step and exposure. Throws
/// stria::Error where the sheet does not pass it.
/// @param field  as crossing_at_depth() takes it
DepthAdvice look_at(const AdvisedScanner& scanner, const Lens& lens, double depth_mm,
                    const Eigen::Vector2d& field = {0, 0});

/// Electrons a second of the brightest sample from a surface of that albedo, the footprint's blur
/// of the pulse included.
double peak_rate(const AdvisedScanner& scanner, const Lens& lens, const DepthAdvice& at,
                 double albedo);

/// Signal, bounds, speckle and edges at a depth for one step and exposure.
void add_sigmas(const AdvisedScanner& scanner, const Lens& lens, double step, double exposure_us,
                DepthAdvice& at);

/// The beam of the channel as Gaussian optics see it, and how far a crossing is from its waist.
GaussianBeam beam_of(const AdvisedScanner& scanner);
double from_waist_mm(const AdvisedScanner& scanner, const Crossing& crossing);
/// D_eff of accuracy.md finding 5 for a wavefront of that radius at a crossing. The light turns
/// about the mirror (swept), not at all (rail), or with the part about the table's axis, one way or
/// the other: there the worse is taken, 1 / D_eff = 1 / r + 1 / |R|.
double effective_distance_at(const AdvisedScanner& scanner, const Crossing& crossing,
                             double wavefront_mm);

}  // namespace stria
