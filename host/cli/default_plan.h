#pragma once
#include "firmware/core/scan_plan.h"
#include "firmware/protocol/messages.h"

namespace stria {

/// A plan for a device of which no more is known: the whole travel; spacetime on a swept machine, a
/// step a standard deviation of the beam; spatial with 512 steps on a rail, with half degrees on a
/// turntable.
ScanPlan default_plan(const Snapshot& info);

}  // namespace stria
