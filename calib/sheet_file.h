#pragma once
#include <Eigen/Core>
#include <string>

#include "host/core/camera_model.h"

namespace stria {

/// What a sheet's file holds: the sheet, and the camera in whose frame it is.
struct MeasuredSheet {
    CameraModel camera;
    Eigen::Vector3d normal = Eigen::Vector3d::UnitX();     ///< unit; offset_mm > 0
    double offset_mm = 0;                                  ///< normal . p = offset_mm
    Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< of (normal, offset_mm)
};

/// sheet.toml: [camera] as in camera.toml, [sheet] normal, offset_mm, covariance (4 x 4, row by
/// row). Numbers read back bit by bit. Refuses (FileError with the line) a normal that is not unit
/// within 1e-6, an offset that is not above 0, a covariance that is not symmetric or has negative
/// variances, and unknown keys.
std::string format_sheet(const MeasuredSheet& sheet);
MeasuredSheet parse_sheet(const std::string& text, const std::string& name);
MeasuredSheet read_sheet(const std::string& path);
void write_sheet(const std::string& path, const MeasuredSheet& sheet);

}  // namespace stria
