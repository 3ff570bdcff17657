#include "host/core/scanner_model.h"

#include <Eigen/Geometry>
#include <cmath>

namespace stria {
namespace {

const Eigen::Matrix3d kScanAxes = Eigen::Vector3d(1, -1, -1).asDiagonal();

double mirror_angle(const MirrorAxis& mirror, double s) {
    return s + s * s * (mirror.g2 + s * mirror.g3);
}

/// Point (camera frame) on the ray where it meets the sheet; Newton steps for the bow.
std::optional<Eigen::Vector3d> meet(const LaserSheet& sheet, const Eigen::Vector3d& ray) {
    const double sin_incidence = sheet.normal.dot(ray) / ray.norm();
    if (std::abs(sin_incidence) < 0.01) return std::nullopt;
    double depth = sheet.offset_mm / sheet.normal.dot(ray);
    if (sheet.bow2 != 0 || sheet.bow3 != 0) {
        for (int i = 0; i < 6; ++i) {
            const double f = signed_distance(sheet, depth * ray);
            const double h = 1e-4 * std::abs(depth) + 1e-9;
            const double slope = (signed_distance(sheet, (depth + h) * ray) - f) / h;
            depth -= f / slope;
        }
    }
    if (!(depth > 0) || !std::isfinite(depth)) return std::nullopt;
    return Eigen::Vector3d(depth * ray);
}

/// Gradient of the signed distance by central differences of 1e-3 mm; the flat normal where flat.
Eigen::Vector3d sheet_normal_at(const LaserSheet& sheet, const Eigen::Vector3d& p) {
    if (sheet.bow2 == 0 && sheet.bow3 == 0) return sheet.normal;
    Eigen::Vector3d gradient;
    const double h = 1e-3;
    for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(i);
        gradient[i] =
            (signed_distance(sheet, p + step) - signed_distance(sheet, p - step)) / (2 * h);
    }
    return gradient;
}

Eigen::Vector3d turned(const Eigen::Vector3d& v, double by_a, double by_b) {
    Eigen::Vector3d a, b;
    tangent_basis(v, a, b);
    return rotation_from_vector(by_a * a + by_b * b) * v;
}

}  // namespace

const char* name_of(MachineKind kind) {
    switch (kind) {
        case MachineKind::swept:
            return "swept";
        case MachineKind::rail:
            return "rail";
        case MachineKind::turntable:
            return "turntable";
    }
    return "?";
}

std::optional<MachineKind> machine_kind_from(const std::string& name) {
    for (MachineKind kind : {MachineKind::swept, MachineKind::rail, MachineKind::turntable})
        if (name == name_of(kind)) return kind;
    return std::nullopt;
}

LaserSheet sheet_at(const Channel& channel, double s) {
    if (channel.axis.kind != MachineKind::swept) return channel.sheet;
    const MirrorAxis& mirror = channel.axis.mirror;
    const Eigen::Vector3d m =
        rotation_from_vector(mirror_angle(mirror, s) * mirror.direction) * mirror.normal0;
    return reflected(channel.sheet, m, mirror.point, mirror.offset_mm);
}

Rigid3 scan_from_camera(const Channel& channel, double s) {
    switch (channel.axis.kind) {
        case MachineKind::swept:
            break;
        case MachineKind::rail:
            return {kScanAxes, s * (kScanAxes * channel.axis.rail.direction)};
        case MachineKind::turntable:
            return Rigid3{rotation_from_vector({0, 0, -s}), Eigen::Vector3d::Zero()} *
                   channel.axis.turntable.table_from_camera;
    }
    return {kScanAxes, Eigen::Vector3d::Zero()};
}

void tangent_basis(const Eigen::Vector3d& n, Eigen::Vector3d& a, Eigen::Vector3d& b) {
    int smallest = 0;
    n.cwiseAbs().minCoeff(&smallest);
    a = n.cross(Eigen::Vector3d::Unit(smallest)).normalized();
    b = n.cross(a);
}

std::vector<std::string> parameter_names(const ScannerModel& model) {
    static const char* const kDistortion[8] = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
    std::vector<std::string> names;
    for (std::size_t c = 0; c < model.channels.size(); ++c) {
        const Channel& channel = model.channels[c];
        const std::string prefix = "channel" + std::to_string(c) + ".";
        const auto add = [&](const char* name) { names.push_back(prefix + name); };
        for (const char* name : {"camera.fx", "camera.fy", "camera.cx", "camera.cy"}) add(name);
        for (int i = 0; i < distortion_count(channel.camera.kind); ++i)
            names.push_back(prefix + "camera." + kDistortion[i]);
        for (const char* name :
             {"sheet.tilt_a", "sheet.tilt_b", "sheet.offset", "sheet.bow2", "sheet.bow3"})
            add(name);
        switch (channel.axis.kind) {
            case MachineKind::swept:
                for (const char* name : {"mirror.axis_a", "mirror.axis_b", "mirror.point_a",
                                         "mirror.point_b", "mirror.normal_a", "mirror.normal_b",
                                         "mirror.offset", "mirror.g2", "mirror.g3"})
                    add(name);
                break;
            case MachineKind::rail:
                for (const char* name : {"rail.direction_a", "rail.direction_b"}) add(name);
                break;
            case MachineKind::turntable:
                for (const char* name :
                     {"table.rx", "table.ry", "table.rz", "table.tx", "table.ty", "table.tz"})
                    add(name);
                break;
        }
        add("axis.delay");
    }
    return names;
}

ScannerModel perturbed(const ScannerModel& model, const Eigen::VectorXd& delta) {
    ScannerModel moved = model;
    Eigen::Index next = 0;
    const auto take = [&] { return delta[next++]; };
    for (Channel& channel : moved.channels) {
        CameraModel& camera = channel.camera;
        camera.fx += take();
        camera.fy += take();
        camera.cx += take();
        camera.cy += take();
        for (int i = 0; i < distortion_count(camera.kind); ++i)
            camera.distortion[static_cast<std::size_t>(i)] += take();

        LaserSheet& sheet = channel.sheet;
        const double tilt_a = take(), tilt_b = take();
        const Eigen::Vector3d old_normal = sheet.normal;
        sheet.normal = turned(old_normal, tilt_a, tilt_b);
        sheet.offset_mm += take();
        sheet.bow2 += take();
        sheet.bow3 += take();
        sheet = normalised(sheet);

        switch (channel.axis.kind) {
            case MachineKind::swept: {
                MirrorAxis& mirror = channel.axis.mirror;
                const double axis_a = take(), axis_b = take();
                const double point_a = take(), point_b = take();
                const double normal_a = take(), normal_b = take();
                Eigen::Vector3d a, b;
                tangent_basis(mirror.direction, a, b);
                mirror.point += point_a * a + point_b * b;
                mirror.direction = turned(mirror.direction, axis_a, axis_b);
                mirror.normal0 = turned(mirror.normal0, normal_a, normal_b);
                mirror.offset_mm += take();
                mirror.g2 += take();
                mirror.g3 += take();
                break;
            }
            case MachineKind::rail: {
                const double a = take(), b = take();
                channel.axis.rail.direction = turned(channel.axis.rail.direction, a, b);
                break;
            }
            case MachineKind::turntable: {
                Vector6d motion;
                for (int i = 0; i < 6; ++i) motion[i] = take();
                channel.axis.turntable.table_from_camera =
                    rigid_from_vector(motion) * channel.axis.turntable.table_from_camera;
                break;
            }
        }
        channel.axis.delay_ns += take();
    }
    return moved;
}

std::optional<Triangulation> triangulate(const Channel& channel, const Eigen::Vector2d& pixel,
                                         double s) {
    const LaserSheet sheet = sheet_at(channel, s);
    const Eigen::Vector3d ray = ray_through(channel.camera, pixel);
    const auto point = meet(sheet, ray);
    if (!point) return std::nullopt;

    const Rigid3 scan = scan_from_camera(channel, s);
    Triangulation result;
    result.point_in_scan = scan * *point;
    result.ray_in_scan = (scan.rotation * ray).normalized();

    // A change of the pixel moves the point inside the sheet; one of s moves it along the ray.
    const Eigen::Vector3d n = sheet_normal_at(sheet, *point);
    const double across = n.dot(ray);
    const auto along_sheet = [&](const Eigen::Vector2d& pixel_step) -> Eigen::Vector3d {
        const Eigen::Vector3d d_ray = (ray_through(channel.camera, pixel + pixel_step) -
                                       ray_through(channel.camera, pixel - pixel_step)) /
                                      (2 * pixel_step.norm());
        const Eigen::Vector3d sideways = point->z() * d_ray;
        return scan.rotation * (sideways - ray * (n.dot(sideways) / across));
    };
    result.d_point_d_u = along_sheet({0.01, 0});
    result.d_point_d_v = along_sheet({0, 0.01});

    if (channel.axis.kind == MachineKind::swept) {
        const double h = 1e-6;  // rad
        const auto after = meet(sheet_at(channel, s + h), ray);
        const auto before = meet(sheet_at(channel, s - h), ray);
        if (!after || !before) return std::nullopt;
        result.d_point_d_s = scan.rotation * (*after - *before) / (2 * h);
    } else if (channel.axis.kind == MachineKind::rail) {
        result.d_point_d_s = scan.rotation * channel.axis.rail.direction;
    } else {
        result.d_point_d_s = -Eigen::Vector3d::UnitZ().cross(result.point_in_scan);
    }
    return result;
}

const Channel* find_channel(const ScannerModel& model, std::uint8_t camera_id,
                            std::uint8_t laser_id) {
    for (const Channel& channel : model.channels)
        if (channel.camera_id == camera_id && channel.laser_id == laser_id) return &channel;
    return nullptr;
}

std::string validate(const ScannerModel& model) {
    if (model.channels.empty()) return "no [[channel]]: expected at least one";
    for (std::size_t i = 0; i < model.channels.size(); ++i) {
        const Channel& channel = model.channels[i];
        const std::string where = "channel " + std::to_string(i) + ": ";
        if (const std::string why = validate(channel.camera); !why.empty())
            return where + "camera." + why;
        const LaserSheet& sheet = channel.sheet;
        if (!(std::abs(sheet.normal.norm() - 1) < 1e-6))
            return where + "sheet.normal has length " + std::to_string(sheet.normal.norm()) +
                   ": expected 1";
        if (!std::isfinite(sheet.offset_mm)) return where + "sheet.offset_mm is not finite";
        if (!sheet.apex.allFinite() || !sheet.central_ray.allFinite())
            return where + "sheet.apex and sheet.central_ray: expected finite numbers";
        if (!(sheet.waist_sigma_mm > 0))
            return where + "sheet.waist_sigma_mm = " + std::to_string(sheet.waist_sigma_mm) +
                   ": expected above 0";
    }
    const auto count = static_cast<Eigen::Index>(parameter_names(model).size());
    if (model.covariance.size() != 0 &&
        (model.covariance.rows() != count || model.covariance.cols() != count))
        return "covariance is " + std::to_string(model.covariance.rows()) + " x " +
               std::to_string(model.covariance.cols()) + ": expected " + std::to_string(count) +
               " x " + std::to_string(count);
    return "";
}

}  // namespace stria
