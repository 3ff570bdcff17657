#include <algorithm>
#include <cmath>
#include <sstream>

#include "firmware/acquire/acquire.h"
#include "firmware/acquire/path_sweep.h"

namespace stria {
namespace {

TimeNs from_us(double us) { return std::llround(us * 1000.0); }

std::vector<TimeNs> exposures_of(const ScanPlan& plan, const AcquireOptions& options) {
    if (plan.exposures_us.empty()) return {options.exposure_ns};
    std::vector<TimeNs> exposures;
    for (double us : plan.exposures_us) exposures.push_back(from_us(us));
    return exposures;
}

std::string bad(const char* field, double found, const char* unit, double low, double high) {
    std::ostringstream text;
    text << field << " = " << found << unit << ": expected " << low << " to " << high << unit
         << " on this device";
    return text.str();
}

std::string check_exposure(const char* field, TimeNs exposure, const CameraInfo& camera) {
    if (exposure >= camera.min_exposure_ns && exposure <= camera.max_exposure_ns) return "";
    const auto us = [](TimeNs time) { return static_cast<double>(time) * 1e-3; };
    return bad(field, us(exposure), " us", us(camera.min_exposure_ns), us(camera.max_exposure_ns));
}

double emission_of(const std::vector<SweepPass>& passes) {
    double seconds = 0;
    for (const SweepPass& pass : passes) seconds += std::abs(pass.to - pass.from) / pass.speed;
    return seconds;
}

}  // namespace

std::vector<SweepPass> passes_of(const ScanPlan& plan, const Devices& devices,
                                 const AcquireOptions& options) {
    const CameraInfo camera = devices.camera.info();
    const double max_speed = devices.axis.info().max_speed;
    const std::vector<TimeNs> exposures = exposures_of(plan, options);
    std::vector<SweepPass> passes;
    for (std::uint8_t laser : plan.lasers) {
        for (std::size_t k = 0; k < exposures.size(); ++k) {
            SweepPass pass{.from = plan.from, .to = plan.to, .laser_id = laser};
            pass.exposure_index = static_cast<std::uint8_t>(k);
            pass.exposure_ns = exposures[k];
            const auto slowest = static_cast<TimeNs>(std::ceil(plan.step / max_speed * 1e9));
            pass.frame_period_ns = std::max(
                {options.frame_period_ns, camera.min_frame_period_ns, exposures[k], slowest});
            pass.speed = plan.step / (static_cast<double>(pass.frame_period_ns) * 1e-9);
            pass.frames =
                static_cast<std::uint32_t>((plan.to - plan.from) / plan.step * (1 + 1e-9)) + 1;
            passes.push_back(pass);
            if (!plan.both_directions) continue;
            std::swap(pass.from, pass.to);
            passes.push_back(pass);
        }
    }
    return passes;
}

std::string validate(const ScanPlan& plan, const Devices& devices, const AcquireOptions& options) {
    if (std::string why = validate(plan); !why.empty()) return why;
    if (follows_paths(plan, options) && paths_followed(plan, options).empty())
        return "mode = spacetime: this machine moves the part against the camera, where pulses lie "
               "along image paths: expected the paths of its calibration for every laser of the "
               "plan (" +
               describe_paths(options) + "), or record = frames, or mode = spatial";
    const AxisInfo axis = devices.axis.info();
    if (plan.from < axis.min_s) return bad("from", plan.from, "", axis.min_s, axis.max_s);
    if (plan.to > axis.max_s) return bad("to", plan.to, "", axis.min_s, axis.max_s);
    if (!(axis.max_speed > 0)) return "axis: its greatest speed must be above 0";
    const CameraInfo camera = devices.camera.info();
    for (TimeNs exposure : exposures_of(plan, options))
        if (std::string why = check_exposure("exposures_us", exposure, camera); !why.empty())
            return why;
    if (plan.off_frames > 0 && plan.off_exposure_us > 0)
        if (std::string why =
                check_exposure("off_exposure_us", from_us(plan.off_exposure_us), camera);
            !why.empty())
            return why;
    const std::size_t lasers = 1 + devices.further_lasers.size();
    for (std::uint8_t laser : plan.lasers)
        if (laser >= lasers)
            return "lasers: there is no laser " + std::to_string(laser) + ": expected 0 to " +
                   std::to_string(lasers - 1);
    const double budget = std::min(plan.max_emission_s, options.max_emission_s);
    const double needed = emission_of(passes_of(plan, devices, options));
    if (needed > budget) return bad("laser time needed", needed, " s", 0, budget);
    return "";
}

}  // namespace stria
