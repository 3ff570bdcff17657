#include "host/scan/profiler_frame.h"

#include <Eigen/Geometry>

#include "host/core/errors.h"

namespace stria {
namespace {

void move_point(RangePoint& point, const Rigid3& motion) {
    const Eigen::Matrix3f turn = motion.rotation.cast<float>();
    point.position = motion * point.position;
    point.normal = turn * point.normal;
    point.error_direction = turn * point.error_direction;
}

}  // namespace

Rigid3 profiler_from_scan(const Channel& channel, double middle_s) {
    const Rigid3 scan = scan_from_camera(channel, middle_s);
    const LaserSheet sheet = sheet_at(channel, middle_s);
    Eigen::Vector3d travel;
    switch (channel.axis.kind) {
        case MachineKind::rail:
            travel = scan.rotation * channel.axis.rail.direction;
            break;
        case MachineKind::swept: {
            // The sheet's normal, signed the way the sheet moves.
            const double step = 1e-4;  // rad
            const LaserSheet next = sheet_at(channel, middle_s + step);
            const Eigen::Vector3d ahead = next.apex + 100 * next.central_ray;
            const double side = sheet.normal.dot(ahead) - sheet.offset_mm;
            travel = scan.rotation * sheet.normal * (side < 0 ? -1.0 : 1.0);
            break;
        }
        case MachineKind::turntable:
            throw Error(
                "a turntable has no direction of travel, so there is no profiler frame; leave "
                "--frame out");
    }
    const Eigen::Vector3d y = travel.normalized();
    Eigen::Vector3d z = -(scan.rotation * sheet.central_ray);
    z = (z - y.dot(z) * y).normalized();
    Rigid3 profiler;
    profiler.rotation.row(0) = y.cross(z).transpose();
    profiler.rotation.row(1) = y.transpose();
    profiler.rotation.row(2) = z.transpose();
    return profiler;
}

RangeImage moved(const RangeImage& image, const Rigid3& motion) {
    RangeImage result = image;
    for (std::size_t i = 0; i < result.cell_count(); ++i)
        if (result.mask[i]) move_point(result.points[i], motion);
    for (FurtherReturn& further : result.further) move_point(further.point, motion);
    for (Station& station : result.stations) {
        station.camera_in_scan = motion * station.camera_in_scan;
        station.laser_in_scan = motion * station.laser_in_scan;
    }
    return result;
}

}  // namespace stria
