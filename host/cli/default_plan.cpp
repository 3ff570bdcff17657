#include "host/cli/default_plan.h"

#include "host/core/scanner_model.h"
#include "host/io/model_io.h"

namespace stria {
namespace {

/// Step (rad of the mirror) that moves the stripe by one standard deviation of the beam where the
/// middle of the image meets the sheet in the middle of the travel: over three samples a pulse.
/// Without a stated model a 2048th of the travel.
double swept_step(const Snapshot& info) {
    const double travel = info.device.axis_max - info.device.axis_min;
    if (info.model_text.empty()) return travel / 2048;
    const ScannerModel model = parse_scanner(info.model_text, "the device's nominal model");
    const Channel& channel = model.channels.front();
    const double s = 0.5 * (info.device.axis_min + info.device.axis_max);
    const Eigen::Vector2d middle(0.5 * (channel.camera.width - 1),
                                 0.5 * (channel.camera.height - 1));
    const auto hit = triangulate(channel, middle, s);
    if (!hit) return travel / 2048;
    const LaserSheet sheet = sheet_at(channel, s);
    const Eigen::Vector3d point = scan_from_camera(channel, s).inverse() * hit->point_in_scan;
    return sigma_at(sheet, point) / (2.0 * (point - sheet.apex).norm());  // the beam turns 2 s
}

}  // namespace

ScanPlan default_plan(const Snapshot& info) {
    const DeviceDescription& device = info.device;
    ScanPlan plan;
    plan.from = device.axis_min;
    plan.to = device.axis_max;
    plan.mode = device.kind == "swept" ? StripeMode::spacetime : StripeMode::spatial;
    plan.step = device.kind == "swept" ? swept_step(info) : (plan.to - plan.from) / 512;
    if (device.kind == "turntable") {
        constexpr double kTurn = 6.283185307179586;
        if (plan.to - plan.from > kTurn) plan.to = plan.from + kTurn;
        plan.step = kTurn / 720;
    }
    return plan;
}

}  // namespace stria
