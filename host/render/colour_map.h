#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "host/core/tri_mesh.h"

namespace stria {

/// sequential: dark blue over green to yellow, even steps to the eye also in grey (control points
/// of viridis, Smith & van der Walt 2015). diverging: blue - light grey - red, for signed errors.
enum class ColourMap { sequential, diverging, grey };

/// What a colour means: a number in `unit` from `low` (one end of the map) to `high`.
struct ColourScale {
    ColourMap map = ColourMap::sequential;
    double low = 0;
    double high = 1;
    std::string label;  ///< "signed distance to the truth"
    std::string unit;   ///< "mm"
};

/// R G B, 0..1. Values beyond the scale take its ends; NaN is a mid grey.
Eigen::Vector3f colour_of(const ColourScale& scale, double value);

/// Diverging scale from -limit to +limit, limit the given quantile of the absolute values, rounded
/// up to 1, 2 or 5 times a power of ten. Values that are not finite are left out.
ColourScale symmetric_scale(const std::vector<float>& values, double quantile, std::string label,
                            std::string unit);
/// Sequential scale from 0 to the quantile of the values, rounded likewise.
ColourScale positive_scale(const std::vector<float>& values, double quantile, std::string label,
                           std::string unit);

/// One colour a vertex from a one-component attribute; throws std::invalid_argument if missing.
std::vector<Eigen::Vector3f> vertex_colours(const TriMesh& mesh, const std::string& attribute,
                                            const ColourScale& scale);

}  // namespace stria
