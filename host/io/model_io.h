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
void write_camera(const std::string& path, const CameraModel& camera);

/// scanner.toml, as a file and as text (recordings carry it). `name` stands for the path in errors.
ScannerModel read_scanner(const std::string& path);
void write_scanner(const std::string& path, const ScannerModel& model);
ScannerModel parse_scanner(const std::string& text, const std::string& name);
std::string format_scanner(const ScannerModel& model);

/// plan.toml.
ScanPlan read_plan(const std::string& path);
std::string format_plan(const ScanPlan& plan);

/// poses.toml; Stanford .conf (bmesh lines, the quaternion conjugated); text files of one 4x4
/// matrix. Translations are multiplied by mm_per_unit.
std::vector<ScanPose> read_poses(const std::string& path, double mm_per_unit = 1.0);
void write_poses(const std::string& path, const std::vector<ScanPose>& poses);
/// Pose of that scan: matched by path, then by file stem. Throws stria::Error if none or two fit.
const ScanPose& find_pose(const std::vector<ScanPose>& poses, const std::string& scan_path);

}  // namespace stria
