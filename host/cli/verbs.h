#pragma once
#include <memory>

#include "host/cli/command.h"

/// One maker a verb, each in its own file verb_NAME.cpp.
namespace stria {

}  // namespace stria
