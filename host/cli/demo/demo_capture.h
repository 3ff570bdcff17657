#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "firmware/core/scan_plan.h"
#include "host/link/device_client.h"

namespace stria {

/// Runs `plan` on simulated devices, all alike, for each view 0..views-1 of their scene, one
/// recording each, FOLDER/0001/recording.stria, ... Two devices share the views, one for the even
/// and one for the odd ones, side by side if there is more than one thread. Throws stria::Error
/// where a run ends early.
/// @param open      opens a device; called on several threads
/// @param on_frame  frames taken so far, of how many; never called twice at once
/// @return the recordings' paths
std::vector<std::string> capture_views(
    const std::function<std::unique_ptr<DeviceClient>()>& open, const ScanPlan& plan, int views,
    const std::string& folder,
    const std::function<void(std::size_t done, std::size_t total)>& on_frame);

/// A few laser-on frames of the present view spread over the sweep, for people to look at.
std::vector<Frame> sample_stripe_frames(DeviceClient& device, const ScanPlan& plan, int count);

/// "0001" for 0.
std::string scan_name(std::size_t index);

}  // namespace stria
