#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/core/camera_model.h"
#include "host/core/laser_sheet.h"
#include "host/core/rigid3.h"

namespace stria {

/// What moves while the stripe passes over the part.
enum class MachineKind : std::uint8_t { swept, rail, turntable };
/// "swept", "rail", "turntable" (scene.toml, range.ply).
const char* name_of(MachineKind kind);
std::optional<MachineKind> machine_kind_from(const std::string& name);

/// Turning plane mirror: points with m(s) . (p - point) = offset_mm, m(s) = Rot(direction, g(s))
/// m0, g(s) = s + g2 s^2 + g3 s^3, s mechanical (the beam turns 2 s). Camera frame.
struct MirrorAxis {
    Eigen::Vector3d direction = Eigen::Vector3d::UnitY();  ///< unit
    Eigen::Vector3d point = Eigen::Vector3d::Zero();     ///< of the axis, nearest the camera centre
    Eigen::Vector3d normal0 = Eigen::Vector3d::UnitZ();  ///< m0, unit
    double offset_mm = 0;                                ///< h
    double g2 = 0, g3 = 0;
};

/// Travel of the head against the part, unit vector in the camera frame:
/// p_scan = R p_camera + s R d, R = diag(1, -1, -1).
struct RailAxis {
    Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
};

/// p_scan = Rz(-s) table_from_camera p_camera; s > 0 turns the table counter-clockwise from +z.
struct TurntableAxis {
    Rigid3 table_from_camera;
};

struct AxisModel {
    MachineKind kind = MachineKind::swept;
    MirrorAxis mirror;        ///< used by swept
    RailAxis rail;            ///< used by rail
    TurntableAxis turntable;  ///< used by turntable
    double delay_ns = 0;      ///< true time = stamp + delay
};

/// One camera watching one laser on one axis. For a swept machine `sheet` is the incoming one,
/// before the mirror; for the others it is the sheet itself.
struct Channel {
    std::uint8_t camera_id = 0;
    std::uint8_t laser_id = 0;
    CameraModel camera;
    LaserSheet sheet;
    AxisModel axis;
};

/// Where the model may be used: a box in the scan frame, mm.
struct ValidVolume {
    Eigen::Vector3d min = Eigen::Vector3d::Zero();
    Eigen::Vector3d max = Eigen::Vector3d::Zero();
    bool is_empty() const { return !(min.array() < max.array()).all(); }
};

/// Where a model came from, as text for people and checks.
struct Provenance {
    std::string made_by;    ///< program and version
    std::string date;       ///< ISO 8601; empty when made from a seed, so that bytes repeat
    std::string data_hash;  ///< of the calibration recordings
    double rms_px = 0;
};

/// A calibrated scanner.
struct ScannerModel {
    std::vector<Channel> channels;
    /// Joint covariance of the parameters that parameter_names() lists, in that order; 0 x 0 if
    /// unknown. The parameters are differences from this model, see perturbed().
    Eigen::MatrixXd covariance;
    ValidVolume volume;
    Provenance provenance;
};

/// The sheet, in the camera frame, when the axis is at s.
LaserSheet sheet_at(const Channel& channel, double s);
/// p_in_scan = scan_from_camera(channel, s) * p_in_camera.
Rigid3 scan_from_camera(const Channel& channel, double s);

/// Names of a model's parameters: "channel0.camera.fx", ... Every one is a small difference from
/// the model: fx fy cx cy and the lens kind's distortion; sheet.tilt_a, sheet.tilt_b (rad,
/// rotations of the normal about the two vectors of tangent_basis(normal)), sheet.offset (mm),
/// sheet.bow2, sheet.bow3; swept: mirror.axis_a, axis_b (rad), mirror.point_a, point_b (mm, along
/// tangent_basis(direction)), mirror.normal_a, normal_b (rad), mirror.offset (mm), mirror.g2, g3;
/// rail: rail.direction_a, direction_b (rad); turntable: table.rx ry rz (rad) tx ty tz (mm), a
/// motion on the left of table_from_camera; all: axis.delay (ns).
std::vector<std::string> parameter_names(const ScannerModel& model);

/// The model moved by `delta`, one number for each parameter name.
ScannerModel perturbed(const ScannerModel& model, const Eigen::VectorXd& delta);

/// Two unit vectors orthogonal to unit vector n and to each other, a fixed function of n.
void tangent_basis(const Eigen::Vector3d& n, Eigen::Vector3d& a, Eigen::Vector3d& b);

/// Where a pixel's ray meets the sheet.
struct Triangulation {
    Eigen::Vector3d point_in_scan;  ///< mm
    Eigen::Vector3d ray_in_scan;    ///< unit, away from the camera
    Eigen::Vector3d d_point_d_s;    ///< mm per unit of s, the pixel kept
    Eigen::Vector3d d_point_d_u;    ///< mm per px, s kept: stays inside the sheet
    Eigen::Vector3d d_point_d_v;
};

/// Point where the ray of pixel (u, v) meets sheet(s), moved into the scan frame, and how it
/// changes. Empty where the ray grazes the sheet (below 0.01 rad), leads away from it, or the point
/// lies behind the camera. DESIGN: one model for every scanner.
std::optional<Triangulation> triangulate(const Channel& channel, const Eigen::Vector2d& pixel,
                                         double s);

/// Channel of that camera and laser; nullptr if the model has none.
const Channel* find_channel(const ScannerModel& model, std::uint8_t camera_id,
                            std::uint8_t laser_id);

/// Empty if usable, else what is wrong (field, value, bound).
std::string validate(const ScannerModel& model);

}  // namespace stria
