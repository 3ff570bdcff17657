#include "firmware/core/axis_log.h"

#include <algorithm>
#include <cmath>

namespace stria {

std::optional<AxisState> position_at(const AxisLog& log, TimeNs time_ns) {
    const auto& samples = log.samples;
    if (samples.size() < 2 || time_ns < samples.front().t_ns || time_ns > samples.back().t_ns)
        return std::nullopt;
    auto after =
        std::upper_bound(samples.begin(), samples.end(), time_ns,
                         [](TimeNs t, const AxisSample& sample) { return t < sample.t_ns; });
    if (after == samples.end()) --after;  // exactly the last sample
    const AxisSample& a = *(after - 1);
    const AxisSample& b = *after;
    const double span_s = static_cast<double>(b.t_ns - a.t_ns) / kNsPerSecond;
    const double slope = (b.s - a.s) / span_s;
    const double since_s = static_cast<double>(time_ns - a.t_ns) / kNsPerSecond;
    return AxisState{.s = a.s + slope * since_s, .ds_dt = slope, .sigma_s = log.sigma_s};
}

bool is_valid(const AxisLog& log) {
    for (std::size_t i = 0; i < log.samples.size(); ++i) {
        if (!std::isfinite(log.samples[i].s)) return false;
        if (i > 0 && log.samples[i].t_ns <= log.samples[i - 1].t_ns) return false;
    }
    return std::isfinite(log.sigma_s) && log.sigma_s >= 0;
}

}  // namespace stria
