#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/core/tri_mesh.h"

namespace stria {

/// Unsigned distances (mm) of samples of one mesh from the surface of another.
struct DistanceFigures {
    std::size_t samples = 0;
    double mean_mm = 0;
    double rms_mm = 0;
    double p95_mm = 0;  ///< 95 % of the samples are at most so far
    double p99_mm = 0;
    double max_mm = 0;
};

struct CompareOptions {
    /// 0: every vertex that a triangle uses; else so many points spread evenly over the area, the
    /// same for the same seed.
    std::size_t samples = 0;
    unsigned seed = 1;
    /// One number a vertex; only vertices, or triangles all of whose vertices, with a non-zero
    /// number are sampled. Empty: all. Surfaces that distances go to are never masked.
    std::vector<std::uint8_t> use_a, use_b;
};

struct MeshComparison {
    DistanceFigures a_to_b;
    DistanceFigures b_to_a;
    double hausdorff_mm = 0;  ///< the greater of both maxima
};

/// Distances from A's samples to B's surface, and back. Throws std::invalid_argument if a mesh has
/// no triangles, or a mask the wrong length.
MeshComparison compare_meshes(const TriMesh& a, const TriMesh& b,
                              const CompareOptions& options = {});

/// Points of a mesh to compare: see CompareOptions.
std::vector<Eigen::Vector3d> sample_surface(const TriMesh& mesh, std::size_t samples, unsigned seed,
                                            const std::vector<std::uint8_t>& use = {});

/// Distance of each point from the mesh's surface, in order.
std::vector<double> distances_to_surface(const std::vector<Eigen::Vector3d>& points,
                                         const TriMesh& mesh);

/// The figures of a set of distances; all 0 for none.
DistanceFigures figures_of(std::vector<double> distances_mm);

}  // namespace stria
