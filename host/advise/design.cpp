#include "host/advise/design.h"

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

#include "firmware/core/angle.h"
#include "host/advise/gaussian_beam.h"

namespace stria {
namespace {

using Eigen::Vector3d;
constexpr double kUsualAngle_rad = 25 * kDegree;
constexpr double kLeastAngle_rad = 2 * kDegree, kMostAngle_rad = 60 * kDegree;
constexpr double kFanMargin = 1.05;
constexpr double kFootprintsWide = 4;  ///< sigma_b over sigma_p: finding 6 asks for 3 to 6

bool above_to(double value, double low, double high) { return value > low && value <= high; }

CameraModel camera_of(const ScannerDesign& design) {
    CameraModel camera;
    camera.width = design.width_px;
    camera.height = design.height_px;
    camera.fx = camera.fy = design.width_px * design.distance_mm / design.width_mm;
    camera.cx = (design.width_px - 1) / 2.0;
    camera.cy = (design.height_px - 1) / 2.0;
    return camera;
}

double near_of(const ScannerDesign& design) { return design.distance_mm - design.depth_mm / 2; }
double far_of(const ScannerDesign& design) { return design.distance_mm + design.depth_mm / 2; }

/// Where the beam's waist is, from the mirror or the laser.
double waist_place(const ScannerDesign& design, double range_mm) {
    return design.waist_at_mm.value_or(design.kind == MachineKind::swept ? 0 : range_mm);
}

double waist_of(const ScannerDesign& design, const CameraModel& camera, double range_mm) {
    if (design.waist_sigma_mm) return *design.waist_sigma_mm;
    Lens lens =
        lens_of(camera.fx, design.sensor.pixel_um, design.sensor.f_number, design.distance_mm);
    lens.aberration_px = design.sensor.aberration_px;
    const double sigma_p_mm = footprint_at(lens, design.wavelength_nm, far_of(design)).sigma_mm();
    return waist_for_mm(kFootprintsWide * sigma_p_mm, range_mm - waist_place(design, range_mm),
                        design.wavelength_nm, design.m_squared);
}

/// The sheet from `from` towards `to`, spanned by the camera's y.
void aim(LaserSheet& sheet, const Vector3d& from, const Vector3d& towards) {
    sheet.apex = from;
    sheet.central_ray = towards.normalized();
    sheet.normal = sheet.central_ray.cross(Vector3d::UnitY()).normalized();
    sheet.offset_mm = sheet.normal.dot(from);
    sheet = normalised(sheet);
}

void aim_mirror(Channel& channel, const ScannerDesign& design, const Vector3d& pivot,
                const Vector3d& out) {
    // From the far side and a little behind, so that the incoming sheet misses the camera.
    const Vector3d in = Vector3d(-1, 0, 0.25).normalized();
    channel.sheet.waist_at_mm += design.laser_to_mirror_mm;
    aim(channel.sheet, pivot - design.laser_to_mirror_mm * in, in);
    MirrorAxis& mirror = channel.axis.mirror;
    mirror.direction = Vector3d::UnitY();
    mirror.point = pivot;
    mirror.normal0 = (out - in).normalized();
}

Rigid3 table_pose(double axis_depth_mm) {
    Eigen::Matrix3d turn;  // z up is the camera's -y; the camera stands on the table's -y
    turn << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    return {turn, Vector3d(0, -axis_depth_mm, 0)};
}

}  // namespace

std::string validate(const ScannerDesign& d) {
    if (std::string why = validate(d.sensor); !why.empty()) return why;
    if (std::string why = validate(d.surface); !why.empty()) return why;
    if (!above_to(d.width_mm, 0, 1e5)) return wrong_value("width_mm", d.width_mm, "above 0");
    if (!above_to(d.distance_mm, 0, 1e5))
        return wrong_value("distance_mm", d.distance_mm, "above 0, at most 100 m");
    if (!(d.depth_mm >= 0 && d.depth_mm < 1.8 * d.distance_mm))
        return wrong_value("depth_mm", d.depth_mm,
                           "0 to below 1.8 times the distance: half of it lies before the middle");
    if (d.width_px < 16 || d.width_px > 16384)
        return wrong_value("width_px", d.width_px, "16 to 16384");
    if (d.height_px < 16 || d.height_px > 16384)
        return wrong_value("height_px", d.height_px, "16 to 16384");
    if (!(d.wavelength_nm >= 200 && d.wavelength_nm <= 2000))
        return wrong_value("wavelength_nm", d.wavelength_nm, "200 to 2000");
    if (!above_to(d.power_mw, 0, 1e5))
        return wrong_value("power_mw", d.power_mw, "above 0, at most 100 W");
    if (!(d.m_squared >= 1 && d.m_squared <= 100))
        return wrong_value("m_squared", d.m_squared, "1 to 100: no beam is better than 1");
    if (d.waist_sigma_mm && !above_to(*d.waist_sigma_mm, 0, 100))
        return wrong_value("waist_sigma_mm", *d.waist_sigma_mm, "above 0, at most 100");
    if (d.waist_at_mm && !(std::abs(*d.waist_at_mm) <= 1e5))
        return wrong_value("waist_at_mm", *d.waist_at_mm, "-100000 to 100000");
    if (d.fan_rad && !above_to(*d.fan_rad, 0, 3))
        return wrong_value("fan_rad", *d.fan_rad, "above 0, at most 3");
    if (!(d.laser_to_mirror_mm > 0 && d.laser_to_mirror_mm <= 1e4))
        return wrong_value("laser_to_mirror_mm", d.laser_to_mirror_mm, "above 0, at most 10 m");
    if (d.baseline_mm && !(*d.baseline_mm >= std::tan(kLeastAngle_rad) * d.distance_mm / 2 &&
                           *d.baseline_mm <= 4 * d.distance_mm))
        return wrong_value("baseline_mm", *d.baseline_mm,
                           "1 degree of triangulation to four times the distance");
    if (d.sigma_z_mm && !above_to(*d.sigma_z_mm, 0, d.distance_mm))
        return wrong_value("sigma_z_mm", *d.sigma_z_mm, "above 0, at most the distance");
    if (d.step && !above_to(*d.step, 0, 1e5)) return wrong_value("step", *d.step, "above 0");
    if (!(std::isfinite(d.axis_sigma) && d.axis_sigma >= 0))
        return wrong_value("axis_sigma", d.axis_sigma, "0 or more");
    return "";
}

AdvisedScanner scanner_of(const ScannerDesign& design, double baseline_mm) {
    AdvisedScanner scanner;
    Channel& channel = scanner.channel;
    channel.camera = camera_of(design);
    channel.axis.kind = design.kind;
    const Vector3d pivot(baseline_mm, 0, 0), target(0, 0, design.distance_mm);
    const double range_mm = (target - pivot).norm();
    LaserSheet& sheet = channel.sheet;
    sheet.wavelength_nm = design.wavelength_nm;
    sheet.waist_sigma_mm = waist_of(design, channel.camera, range_mm);
    sheet.waist_at_mm = waist_place(design, range_mm);
    if (design.kind == MachineKind::swept)
        aim_mirror(channel, design, pivot, (target - pivot).normalized());
    else
        aim(sheet, pivot, target - pivot);
    channel.axis.turntable.table_from_camera = table_pose(far_of(design));
    sheet.fan_rad = design.fan_rad.value_or(
        kFanMargin * fan_needed_rad(channel, near_of(design), far_of(design)));
    scanner.sensor = design.sensor;
    scanner.power_mw = design.power_mw;
    scanner.m_squared = design.m_squared;
    scanner.near_mm = near_of(design);
    scanner.middle_mm = scanner.focus_mm = design.distance_mm;
    scanner.far_mm = far_of(design);
    scanner.surface = design.surface;
    scanner.step = design.step;
    scanner.axis_sigma = design.axis_sigma;
    return scanner;
}

DesignAdvice advise_design(const ScannerDesign& design) {
    if (const std::string why = validate(design); !why.empty()) throw std::invalid_argument(why);
    DesignAdvice result;
    const auto baseline_at = [&](double angle) { return design.distance_mm * std::tan(angle); };
    if (design.sigma_z_mm) {
        // The step advised changes with the baseline; one that was stated must not end the search.
        ScannerDesign free = design;
        free.step.reset();
        const auto worst = [&](double angle) {
            return advise(scanner_of(free, baseline_at(angle))).worst_z_mm();
        };
        double low = kLeastAngle_rad, high = kMostAngle_rad;
        result.best_sigma_z_mm = worst(high);
        if (result.best_sigma_z_mm <= *design.sigma_z_mm) {
            for (int i = 0; i < 40; ++i) {
                const double middle = (low + high) / 2;
                (worst(middle) <= *design.sigma_z_mm ? high : low) = middle;
            }
            result.baseline_for_sigma_mm = baseline_at(high);
        }
    }
    result.baseline_chosen = !design.baseline_mm;
    const double otherwise =
        design.sigma_z_mm ? result.baseline_for_sigma_mm.value_or(baseline_at(kMostAngle_rad))
                          : baseline_at(kUsualAngle_rad);
    result.scanner = scanner_of(design, design.baseline_mm.value_or(otherwise));
    result.advice = advise(result.scanner);
    return result;
}

}  // namespace stria
