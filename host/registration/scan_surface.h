#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "host/core/range_image.h"
#include "host/geometry/nearest.h"
#include "host/registration/occupancy.h"

namespace stria {

struct ScanSurfaceOptions {
    double max_edge_mm = 0;  ///< longest edge that is surface; 0: 4 x the median pitch
    int border_cells = 2;    ///< points nearer to the border (in cells) are not sampled: their
                             ///< normals and their triangulation lean on one side only
    int normal_rounds = 2;   ///< times the normals are averaged with their eight neighbours; noise
                             ///< of sigma tilts a raw normal by about sigma / pitch
};

/// A range image made ready for registration: its surface points with normals, which of them lie
/// on the border, an even nested sampling and a tree to find the nearest. Scan frame, mm.
struct ScanSurface {
    std::vector<Eigen::Vector3d> points;     ///< finite points that belong to a triangle
    std::vector<Eigen::Vector3d> normals;    ///< unit, towards the camera
    std::vector<std::uint8_t> is_border;     ///< 1: a match with this point is not to be trusted
    std::vector<double> sigma_mm;            ///< random, along the normal; empty: unknown
    std::vector<std::uint32_t> samples;      ///< inner points; any first part of it is even
    std::vector<Eigen::Vector3d> to_camera;  ///< unit, from each point
    double pitch_mm = 0;                     ///< median
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< mean of the points
    Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();  ///< bounds
    bool is_whole =
        false;  ///< no point lies on the rim of the grid: nothing of the part is cut off
    std::vector<Station> stations;  ///< as the range image's
    PointTree tree{{}};             ///< of `points`
    OccupancyGrid occupancy;        ///< of `points`

    /// Largest distance of a point from the centre is below this (mm).
    double radius_mm() const { return 0.5 * (high - low).norm(); }
};

/// Surfaces borrowed for the length of a call.
using SurfaceList = std::vector<const ScanSurface*>;
SurfaceList list_of(const std::vector<ScanSurface>& surfaces);

/// Points that are not finite are passed over. An image without surface gives an empty result.
ScanSurface prepare_surface(const RangeImage& image, const ScanSurfaceOptions& options = {});

}  // namespace stria
