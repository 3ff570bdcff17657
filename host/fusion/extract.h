#pragma once
#include "host/core/tri_mesh.h"
#include "host/fusion/closing_body.h"
#include "host/fusion/volume.h"

namespace stria {

struct ExtractOptions {
    bool fill_holes = false;  ///< also the border between unseen and empty space
    int border_rounds = 3;    ///< of tidy_border with gaps of 2 voxels, where holes stay open
    int fill_smoothing_rounds = 20;  ///< umbrella steps of the filled part, to remove its stairs
    /// Components with less measured area are dropped. Default: a square of 10 voxels.
    double min_component_voxels2 = 100;
};

/// The zero surface of the volume: triangles counter-clockwise seen from outside, no edge with more
/// than two. Without fill_holes it ends where a corner of a cell was not near any surface; with
/// it the unseen counts as inside, and the surface is closed. Attributes: "normal" (3, unit, from
/// the triangles), "filled" (1), and "sigma" (1, mm: sqrt(noise^2 + systematic^2) of the mean, 0
/// where filled) when the volume has sigmas. Positions depend on the sums alone.
TriMesh extract_surface(const SdfVolume& volume, const ClosingBody& body,
                        const ExtractOptions& options);

}  // namespace stria
