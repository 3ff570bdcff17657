#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "firmware/core/scan_plan.h"
#include "host/link/device_client.h"

namespace stria {

/// Runs `plan` on a simulated device for each of its views 0..views-1, one recording each,
/// FOLDER/0001/recording.stria, ... Throws stria::Error where a run ends early.
/// @param on_frame  frames taken so far, of how many
/// @return the recordings' paths
std::vector<std::string> capture_views(
    DeviceClient& device, const ScanPlan& plan, int views, const std::string& folder,
    const std::function<void(std::size_t done, std::size_t total)>& on_frame);

/// A few laser-on frames of the present view spread over the sweep, for people to look at.
std::vector<Frame> sample_stripe_frames(DeviceClient& device, const ScanPlan& plan, int count);

/// "0001" for 0.
std::string scan_name(std::size_t index);

}  // namespace stria
