#pragma once
#include <cstddef>
#include <vector>

#include "host/cli/demo/sculpture_truth.h"
#include "host/core/range_image.h"
#include "host/core/tri_mesh.h"

namespace stria {

/// Distribution of distances, mm.
struct ErrorFigures {
    std::size_t count = 0;
    double mean_mm = 0, rms_mm = 0, p95_mm = 0, p99_mm = 0, max_mm = 0;
};
ErrorFigures error_figures(std::vector<double> distances_mm);

/// The mesh against the truth.
struct MeshTruth {
    Rigid3 object_from_world;  ///< best rigid motion of the whole mesh
    ErrorFigures smooth;  ///< both directions pooled, farther than 3 mm from creases, no relief
    ErrorFigures all;     ///< both directions pooled
    ErrorFigures mesh_to_truth;
    ErrorFigures truth_to_mesh;
    double seen_share = 0;               ///< of the truth's samples: seen at under 70 deg
    std::vector<float> vertex_error_mm;  ///< of every vertex: unsigned distance to the truth
};

/// Compares as the report says: vertices of the mesh without filled parts whose nearest true point
/// was seen under 70 deg, and 100 000 seen samples of the truth to the mesh.
/// @param object_from_world  where the mesh lies, to some mm
MeshTruth compare_with_truth(const TriMesh& measured, const SculptureTruth& truth,
                             const std::vector<TrueView>& views, const Rigid3& object_from_world,
                             unsigned seed);

/// Every vertex of a mesh with filled parts (attribute "filled"), and those parts apart.
struct FilledTruth {
    ErrorFigures filled;
    std::vector<float> vertex_error_mm;
};
FilledTruth compare_filled_with_truth(const TriMesh& filled, const SculptureTruth& truth,
                                      const Rigid3& object_from_world);

/// Predicted against actual error of one scan's points.
struct SigmaTruth {
    double sigma_ratio = 0;      ///< 1.4826 MAD of e over its predicted sigma (FORMATS)
    double median_sigma_mm = 0;  ///< random and systematic together, predicted
    double median_error_mm = 0;  ///< of |e|
    std::size_t points = 0;
    Rigid3 object_from_scan;         ///< best rigid motion of this scan alone
    std::vector<double> normalised;  ///< e / sigma of every 20th point, for the plot
};
/// @param object_from_scan  where the scan stands, to some mm; refined by its best rigid motion
SigmaTruth sigma_against_truth(const RangeImage& image, const SculptureTruth& truth,
                               const Rigid3& object_from_scan);

}  // namespace stria
