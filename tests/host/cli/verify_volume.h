#pragma once
#include <string>
#include <vector>

#include "host/core/range_image.h"
#include "sim/scene.h"

/// A simulated swept scanner of 1.6 megapixels before a volume of 300 mm diagonal, and scans of
/// artefacts in it. Blue laser, 12 bits, f/8; a lens of half a pixel's spread; no speckle, no
/// bounced light. The model that triangulates is the true one: what calibration adds is not in
/// here.
namespace stria::test_support {

constexpr double kVolumeDiagonalMm = 300;

/// @param scale  pixels and beam of the camera, 1: 1456 x 1088 px; 0.4 scans in a fraction of the
///               time
Scene volume_scene(double scale);

/// A matt sphere or plate there, scan frame.
SceneObject volume_sphere(const Eigen::Vector3d& centre, double radius_mm);
SceneObject volume_plate(const Rigid3& world_from_object, const Eigen::Vector2d& size_mm);

/// Sphere centres, bars (first centre, second centre) and plate poses that fill the volume. No
/// sphere of a bar hides the other from camera or laser.
std::vector<Eigen::Vector3d> sphere_positions();
std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> bar_positions(double length_mm);
std::vector<Rigid3> plate_positions();

/// The scan of those objects alone: the part of the image around them, the part of the sweep that
/// crosses them, 1.4 frames a beam's standard deviation.
RangeImage scan_volume(Scene scene, const std::vector<SceneObject>& objects, unsigned seed);

/// Keeps the scan as NAME.ply in the folder that STRIA_VERIFY_OUT names, if it does, for
/// `stria verify` and its page.
void keep_scan(const std::string& name, const RangeImage& image);

}  // namespace stria::test_support
