#include "host/scan/light_change.h"

#include <cmath>
#include <optional>

#include "firmware/core/pulse.h"
#include "host/geometry/parallel.h"

namespace stria {
namespace {

using Eigen::Vector3d;
constexpr double kMostChange = 0.5;  // of ln E over a width: beyond, the first order is not enough

/// A surface point as the head sees it with the axis at s.
struct Lit {
    double log_light = 0;    ///< ln of the irradiance, up to a constant
    double distance_mm = 0;  ///< signed, from the sheet's centre
    double width_mm = 0;     ///< of the beam there
};

std::optional<Lit> lit_at(const Channel& channel, const RangePoint& point, double s) {
    const Rigid3 camera_from_scan = scan_from_camera(channel, s).inverse();
    const LaserSheet sheet = sheet_at(channel, s);
    const Vector3d at = camera_from_scan * point.position;
    const Vector3d normal = camera_from_scan.rotation * point.normal.cast<double>();
    const Vector3d to_laser = sheet.apex - at;
    const double facing = normal.dot(to_laser);
    if (!(facing > 0)) return std::nullopt;
    const double r = to_laser.norm(), width = sigma_at(sheet, at);
    return Lit{std::log(facing / (r * r * width)), signed_distance(sheet, at), width};
}

/// By how much the pulse peaks after the crossing, unit of s.
std::optional<double> shift_of(const Channel& channel, const RangePoint& point) {
    const double h = channel.axis.kind == MachineKind::turntable ? 1e-4 : 1e-2;  // rad, mm
    const auto before = lit_at(channel, point, point.s - h);
    const auto after = lit_at(channel, point, point.s + h);
    if (!before || !after) return std::nullopt;
    const double speed = std::abs(after->distance_mm - before->distance_mm) / (2 * h);
    const double width_s = 0.5 * (before->width_mm + after->width_mm) / speed;
    const double change = (after->log_light - before->log_light) / (2 * h);
    if (!(std::abs(change) * width_s < kMostChange)) return std::nullopt;
    return width_s * width_s * change;
}

void correct(RangePoint& point, const Channel& channel) {
    const auto shift = shift_of(channel, point);
    if (!shift) return;
    const double s = point.s - *shift;
    const auto pixel =
        project(channel.camera, scan_from_camera(channel, s).inverse() * point.position);
    if (!pixel) return;
    const auto hit = triangulate(channel, *pixel, s);
    if (!hit) return;
    point.position = hit->point_in_scan;
    point.s = s;
}

}  // namespace

void correct_light_change(RangeImage& image, std::span<const Channel* const> channels) {
    parallel_for_blocks(image.cell_count(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            RangePoint& point = image.points[i];
            if (image.mask[i] == 0 || point.normal.isZero() ||
                (point.flags & kPulseSpatialFallback) != 0)
                continue;
            correct(point, *channels[i]);
        }
    });
}

}  // namespace stria
