#include "host/cli/fast_analysis.h"

#include <algorithm>

#include "host/core/errors.h"

namespace stria {
namespace {

constexpr const char* kFeature = "FastSpacetime";

}  // namespace

void ask_for_fast_analysis(DeviceClient& device, const ScanPlan& plan) {
    if (plan.mode != StripeMode::spacetime)
        throw Error("--fast: expected a plan with mode = \"spacetime\", found \"spatial\"");
    device.set_feature(kFeature, FeatureValue(true));
}

bool was_fast_analysis(const Snapshot& snapshot) {
    return std::any_of(snapshot.features.begin(), snapshot.features.end(), [](const Feature& f) {
        const auto* value = std::get_if<bool>(&f.value);
        return f.name == kFeature && value != nullptr && *value;
    });
}

}  // namespace stria
