#pragma once
#include <vector>

#include "calib/corner_noise.h"
#include "calib/lens_choice.h"
#include "host/cli/command.h"

namespace stria {

/// A choice among lens models, for people: which was taken, and how each fared.
void say_choice(const Context& context, const LensChoice& choice);
/// The same as `lens_trials[] {model held_out_rms_px failed}`.
std::vector<JsonResult> json_of(const LensChoice& choice);

/// Says, where neighbouring corners err together, how, and what helps.
void say_noise(const Context& context, const CornerNoise& noise, const std::string& what_helps);
/// The same as `{sigma_px shared reach_pitches}`.
JsonResult json_of(const CornerNoise& noise);

}  // namespace stria
