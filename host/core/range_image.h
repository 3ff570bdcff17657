#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host/core/rigid3.h"
#include "host/core/scanner_model.h"

namespace stria {

/// Where the lines of sight start when the axis is at s; linear in s between stations.
struct Station {
    double s = 0;
    Eigen::Vector3d camera_in_scan = Eigen::Vector3d::Zero();  ///< mm
    Eigen::Vector3d laser_in_scan = Eigen::Vector3d::Zero();   ///< laser apex, mm
};

/// A point of a range image. Unit vectors and mm in the scan frame.
struct RangePoint {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();           ///< towards the camera; 0: unknown
    Eigen::Vector3f error_direction = Eigen::Vector3f::Zero();  ///< unit, away from the camera
    float sigma_mm = 0;         ///< random, along error_direction; 0: unknown
    float sigma_across_mm = 0;  ///< random, across it
    float sigma_systematic_mm =
        0;  ///< from calibration, shared by all points, along error_direction
    float intensity = 0;
    double s = 0;
    std::uint16_t flags = 0;  ///< PulseFlag
};

/// A further return of a cell that is not its main one.
struct FurtherReturn {
    std::uint32_t cell = 0;
    std::uint8_t return_index = 1;
    RangePoint point;
};

/// One scan as an organised grid: cell (x, y), row-major, width x height, each empty or a point.
/// Neighbouring cells are neighbours on the surface unless an edge between them is too long.
struct RangeImage {
    int width = 0;
    int height = 0;
    MachineKind kind = MachineKind::swept;
    std::vector<std::uint8_t> mask;  ///< 1: the cell has a point
    std::vector<RangePoint> points;  ///< one a cell; meaningless where mask is 0
    std::vector<FurtherReturn> further;
    /// Point displacement (along error_direction, mm) per one standard deviation of each of the few
    /// leading calibration errors, rigid motion removed; [cell x sensitivity_count + k].
    int sensitivity_count = 0;
    std::vector<float> sensitivity;
    /// Ascending in s. None: orthographic, seen from +z along -z. One: constant.
    std::vector<Station> stations;
    std::string model_hash;

    std::size_t cell(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    }
    std::size_t cell_count() const { return mask.size(); }
    bool has(int x, int y) const { return mask[cell(x, y)] != 0; }
    const RangePoint& at(int x, int y) const { return points[cell(x, y)]; }
};

/// An all-empty image of that size.
RangeImage make_range_image(int width, int height);

/// Number of cells with a point.
std::size_t valid_count(const RangeImage& image);

/// Camera centre and laser apex (scan frame) for a point taken at axis position s. Only for images
/// with stations.
Station station_at(const RangeImage& image, double s);

/// Unit vector from the point towards the camera that saw it: +z for an orthographic image.
Eigen::Vector3d direction_to_camera(const RangeImage& image, const RangePoint& point);

}  // namespace stria
