#pragma once
#include "firmware/core/result.h"
#include "firmware/devices/devices.h"

namespace stria {

/// Puts the machine into its one safe state: every laser off, drive disabled, camera stopped. Every
/// failing path ends here. All parts are told, whatever the others answer, and a part that refuses
/// is told a second time; fails with the names of those that refused twice. Never throws.
Status make_safe(const Devices& devices);

}  // namespace stria
