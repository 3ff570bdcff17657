#pragma once
#include <string>

namespace stria {

/// The day by the computer's clock (UTC), ISO 8601.
std::string today();

}  // namespace stria
