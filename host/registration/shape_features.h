#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "host/registration/scan_surface.h"

namespace stria {

/// The surface thinned to about one point a cube of side `detail_mm`, each the mean of the cube's
/// points with their mean normal; a cube that holds a border point is border. All points are
/// samples.
ScanSurface thinned(const ScanSurface& surface, double detail_mm);

/// Local shape of each point: fast point feature histograms (Rusu, Blodow and Beetz 2009, 3 x 11
/// bins) at two radii, one after the other; one column a point, each of the six histograms of
/// sum 1. Invariant to rigid motion.
Eigen::MatrixXf shape_features(const ScanSurface& surface, double small_radius_mm,
                               double large_radius_mm);

/// The points of each surface to look for elsewhere, at most `count` a surface, none on the border:
/// two thirds are those whose features are rarest among all surfaces (corners rather than the
/// flats and rounds that look alike everywhere), the rest is spread evenly.
std::vector<std::vector<std::uint32_t>> distinctive_points(
    const std::vector<const ScanSurface*>& surfaces, const std::vector<Eigen::MatrixXf>& features,
    std::size_t count);

}  // namespace stria
