#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "host/core/range_image.h"
#include "host/core/tri_mesh.h"

namespace stria {

/// What the scanner says a point's standard deviation is, as RangePoint has it.
struct PointNoise {
    Eigen::Vector3f direction = Eigen::Vector3f::Zero();  ///< unit, that of sigma and systematic
    float sigma_mm = 0;
    float across_mm = 0;
    float systematic_mm = 0;  ///< shared by all points of the scan; 0: not known
};

/// A scan as the acceptance procedures take it: points, and what is known about each. What a scan
/// does not say stays empty; nothing is invented for it.
struct ScanPoints {
    std::vector<Eigen::Vector3d> positions;       ///< mm
    std::vector<Eigen::Vector3f> towards_camera;  ///< unit, one a point; empty: not known
    std::vector<PointNoise> noise;                ///< one a point; empty: not known
    /// As RangeImage has them, but by point: [point x sensitivity_count + k].
    int sensitivity_count = 0;
    std::vector<float> sensitivity;

    bool has_sight() const { return !towards_camera.empty(); }
    bool has_noise() const { return !noise.empty(); }
    bool has_systematic() const { return has_noise() && noise.front().systematic_mm > 0; }
};

/// Points of a range image in the order of its cells, further returns left out. The noise counts as
/// known if every point states a sigma and a direction.
ScanPoints scan_points(const RangeImage& image);
/// Points without grid: neither sight nor noise is known.
ScanPoints scan_points(const PointCloud& cloud);

/// The points of those indices.
ScanPoints chosen(const ScanPoints& scan, const std::vector<std::uint32_t>& indices);

/// Standard deviation (mm) of a point along the unit vector: random, or what calibration shares.
double random_along(const PointNoise& noise, const Eigen::Vector3d& along);
double systematic_along(const PointNoise& noise, const Eigen::Vector3d& along);

}  // namespace stria
