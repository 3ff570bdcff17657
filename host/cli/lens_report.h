#pragma once
#include <vector>

#include "calib/lens_choice.h"
#include "host/cli/command.h"

namespace stria {

/// A choice among lens models, for people: which was taken, and how each fared.
void say_choice(const Context& context, const LensChoice& choice);
/// The same as `lens_trials[] {model held_out_rms_px failed}`.
std::vector<JsonResult> json_of(const LensChoice& choice);

}  // namespace stria
