#pragma once
#include <string>
#include <vector>

#include "firmware/core/scan_plan.h"
#include "host/core/camera_model.h"
#include "host/core/scan_pose.h"
#include "host/core/scanner_model.h"

namespace stria {

/// camera.toml. Unknown keys are errors that name the nearest known key; so they are in every TOML
/// file stria reads.
CameraModel read_camera(const std::string& path);
CameraModel parse_camera(const std::string& text, const std::string& name);
std::string format_camera(const CameraModel& camera);
void write_camera(const std::string& path, const CameraModel& camera);

/// scanner.toml, as a file and as text (recordings carry it). `name` stands for the path in errors.
/// Numbers are written so that they read back bit by bit. Refuses what validate() refuses, unit
/// vectors of another length, and a covariance whose names are not parameter_names() in order.
ScannerModel read_scanner(const std::string& path);
void write_scanner(const std::string& path, const ScannerModel& model);
ScannerModel parse_scanner(const std::string& text, const std::string& name);
std::string format_scanner(const ScannerModel& model);

/// plan.toml.
ScanPlan read_plan(const std::string& path);
ScanPlan parse_plan(const std::string& text, const std::string& name);
std::string format_plan(const ScanPlan& plan);

/// By the ending: poses.toml (always in mm); Stanford .conf (bmesh lines, the quaternion
/// conjugated); otherwise a text file of one 4x4 matrix, which belongs to the scan of its own name.
/// Translations of the last two are multiplied by mm_per_unit. Rotations that were printed with few
/// digits are made exact; matrices farther than 0.001 from a rotation are refused.
std::vector<ScanPose> read_poses(const std::string& path, double mm_per_unit = 1.0);
std::vector<ScanPose> parse_poses(const std::string& text, const std::string& name,
                                  double mm_per_unit = 1.0);
std::string format_poses(const std::vector<ScanPose>& poses);
void write_poses(const std::string& path, const std::vector<ScanPose>& poses);
/// Pose of that scan: matched by path, then by the end of the path, then by file stem; a project's
/// scan folder stands for the range.ply and recording.stria in it. Throws stria::Error if none or
/// two fit.
const ScanPose& find_pose(const std::vector<ScanPose>& poses, const std::string& scan_path);

}  // namespace stria
