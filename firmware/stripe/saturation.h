#pragma once
#include "firmware/core/frame.h"

namespace stria {

/// Samples of the frame at full scale.
std::uint32_t count_saturated(const Frame& frame);

}  // namespace stria
