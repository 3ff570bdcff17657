#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/core/range_image.h"
#include "host/core/rigid3.h"
#include "host/core/tri_mesh.h"
#include "host/fusion/closing_body.h"
#include "host/fusion/volume.h"

namespace stria {

/// A scan and where it stands. The image must outlive the call.
struct FuseScan {
    const RangeImage* image = nullptr;
    Rigid3 world_from_scan;
};

struct FuseOptions {
    double voxel_mm = 0;  ///< 0: median over the scans of their median pitch: finer shows noise
    /// Carving ends 3 sigma + ramp in front of the surface, and distances are written 1.5 voxels
    /// farther, so that no gap stays between. 0: 2 voxels, the least that gives every cell at the
    /// surface all its corners.
    double ramp_mm = 0;
    double max_edge_mm = 0;  ///< longer range edges are no surface; 0: 4 x the scan's pitch
    double max_incidence_rad = 1.42;  ///< flatter triangles are left out; 81 deg as VripPack
    int border_taper_cells = 8;       ///< as VripPack: borders of a scan are its worst part
    bool weight_by_sigma = true;      ///< weight with 1 / sigma^2 where all scans know sigma
    bool carve = true;                ///< keep what was seen to be empty
    bool carve_background = false;    ///< cells without return are empty as far as the volume goes
    bool fill_holes = false;          ///< needs carve
    int fill_smoothing_rounds = 20;   ///< see ExtractOptions
    double min_component_voxels2 = 100;
    std::size_t memory_mb = 4096;  ///< of the volume; more is refused

    /// Empty if usable, else field, value and bound.
    std::string validate() const;
};

/// CPU time of all threads, seconds.
struct FuseSeconds {
    double integrate = 0;
    double carve = 0;
    double extract = 0;
};

/// A volume with all its scans in it.
struct FusedVolume {
    SdfVolume volume{1.0};
    ClosingBody body;
    double ramp_mm = 0;
    std::size_t points = 0;     ///< of the scans
    std::size_t triangles = 0;  ///< of their range surfaces
    FuseSeconds cpu_seconds;
};

/// Puts all scans into one volume. Any order of scans and any number of threads gives the same
/// bytes. Throws std::invalid_argument for bad options, stria::Error when no scan has a surface,
/// when the memory limit would be exceeded, or when carve_background meets a scan whose camera
/// moves.
FusedVolume fuse_volume(const std::vector<FuseScan>& scans, const FuseOptions& options = {});

/// The surface of a fused volume; see extract_surface for its attributes.
TriMesh fused_surface(FusedVolume& fused, const FuseOptions& options = {});

/// Both in one: the mesh, and what it took.
struct FuseResult {
    TriMesh mesh;
    double voxel_mm = 0;
    double ramp_mm = 0;
    std::size_t points = 0;
    std::size_t bricks = 0;
    std::size_t volume_bytes = 0;
    FuseSeconds cpu_seconds;
};
FuseResult fuse(const std::vector<FuseScan>& scans, const FuseOptions& options = {});

}  // namespace stria
