#pragma once
#include "firmware/core/scan_plan.h"
#include "host/link/device_client.h"

namespace stria {

/// Sets the device's feature FastSpacetime, for its next runs. Throws DeviceError with the device's
/// reason where it cannot (frames of more than 8 bits, image paths, older firmware), stria::Error
/// where the plan asks for no pulses over time.
void ask_for_fast_analysis(DeviceClient& device, const ScanPlan& plan);

/// True if the device that made a recording analysed it fast, or was to: the feature in its
/// snapshot.
bool was_fast_analysis(const Snapshot& snapshot);

}  // namespace stria
