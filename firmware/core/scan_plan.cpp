#include "firmware/core/scan_plan.h"

#include <cmath>

namespace stria {

std::string validate(const ScanPlan& plan) {
    const auto bad = [](const char* field, double value, const char* bound) {
        return std::string(field) + " = " + std::to_string(value) + ": expected " + bound;
    };
    if (!std::isfinite(plan.from)) return bad("from", plan.from, "a finite position");
    if (!std::isfinite(plan.to) || plan.to <= plan.from) return bad("to", plan.to, "above from");
    if (!std::isfinite(plan.step) || plan.step <= 0) return bad("step", plan.step, "above 0");
    const double frames = (plan.to - plan.from) / plan.step;
    if (frames > 1e6) return bad("step", plan.step, "at most a million steps from from to to");
    for (double us : plan.exposures_us)
        if (!(us > 0 && us <= 1e6)) return bad("exposures_us", us, "0 to 1000000, 0 excluded");
    if (plan.exposures_us.size() > 8)
        return bad("exposures_us", static_cast<double>(plan.exposures_us.size()), "at most 8");
    if (!(plan.laser_power > 0 && plan.laser_power <= 1))
        return bad("laser_power", plan.laser_power, "0 to 1, 0 excluded");
    if (plan.lasers.empty()) return "lasers is empty: expected at least one laser's number";
    if (plan.off_frames < 0 || plan.off_frames > 1000)
        return bad("off_frames", plan.off_frames, "0 to 1000");
    if (!(plan.off_exposure_us >= 0 && plan.off_exposure_us <= 1e6))
        return bad("off_exposure_us", plan.off_exposure_us, "0 to 1000000");
    if (!(plan.max_emission_s > 0 && plan.max_emission_s <= 3600))
        return bad("max_emission_s", plan.max_emission_s, "0 to 3600, 0 excluded");
    return "";
}

}  // namespace stria
