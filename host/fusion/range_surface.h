#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "host/core/range_image.h"
#include "host/core/rigid3.h"

namespace stria {

/// A point of a scan's surface with what fusion needs of it, in the world frame.
struct SurfaceVertex {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< mm
    Eigen::Vector3d camera = Eigen::Vector3d::Zero();    ///< where its line of sight starts, mm
    Eigen::Vector3d laser = Eigen::Vector3d::Zero();     ///< where its laser ray starts, mm
    double s = 0;
    float weight = 0;    ///< in (0, 1]
    float sigma_mm = 0;  ///< 0: unknown
    float systematic_mm = 0;
    bool carves = false;  ///< a single, trusted pulse
};

/// The range surface of one scan, ready to be put into the volume.
struct RangeSurface {
    bool orthographic = false;
    bool camera_moves = false;
    bool laser_moves = false;
    Eigen::Vector3d towards_camera = Eigen::Vector3d::UnitZ();  ///< unit; used if orthographic
    std::vector<SurfaceVertex> vertices;
    std::vector<std::uint32_t> cells;                     ///< of the vertices, ascending
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise for the camera
    /// Triangles from here on join neighbouring cells that are no common surface (an edge too long,
    /// or seen too flat); none unless asked for. The camera saw free space up to their nearest
    /// corner.
    std::size_t first_gap = 0;
    double median_sigma_mm = 0;  ///< 0: unknown
};

struct RangeSurfaceOptions {
    double max_edge_mm = 0;           ///< see RangeGridOptions
    double max_incidence_rad = 1.42;  ///< 81 deg: cosine 0.15, as VripPack's MinViewDot
    int border_taper_cells = 8;       ///< weight grows linearly over so many cells from the border
    bool with_gaps = false;           ///< append the triangles that are no surface
    double reference_sigma_mm = 0;  ///< weight (reference / sigma)^2 where sigma is known; 0: none
};

/// The surface of a scan in the world frame. Weight of a vertex = cos^2 of the angle between its
/// normal and its line of sight x the border taper x the sigma factor, clamped to [1/64, 1].
/// Source: Curless & Levoy 1996, section 3.1.
RangeSurface make_range_surface(const RangeImage& image, const Rigid3& world_from_scan,
                                const RangeSurfaceOptions& options);

/// Median of the known sigma_mm over all points; 0 if none is known.
double median_sigma_mm(const RangeImage& image);

}  // namespace stria
