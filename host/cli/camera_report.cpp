#include "host/cli/camera_report.h"

#include "host/core/short_number.h"

namespace stria {

void say_choice(const Context& context, const LensChoice& choice) {
    for (const LensTrial& trial : choice.trials)
        context.say(std::string("lens model ") + name_of(trial.lens) + ": " +
                    (trial.failed.empty()
                         ? short_number(trial.held_out_rms_px, 4) + " px rms on views held out"
                         : trial.failed));
    context.say(std::string("taken: ") + name_of(choice.lens) +
                ", the simplest that is as good as any within 2 standard errors");
}

std::vector<JsonResult> json_of(const LensChoice& choice) {
    std::vector<JsonResult> trials;
    for (const LensTrial& trial : choice.trials) {
        JsonResult one;
        one.set("model", name_of(trial.lens));
        if (trial.failed.empty())
            one.set("held_out_rms_px", trial.held_out_rms_px);
        else
            one.set("failed", trial.failed);
        trials.push_back(one);
    }
    return trials;
}

void say_noise(const Context& context, const CornerNoise& noise, const std::string& what_helps) {
    if (!noise.refutes_independence()) return;
    context.say("neighbouring corners err together: " + short_number(100 * noise.shared, 2) +
                " % of the variance of " + short_number(noise.sigma_px, 2) + " px, over " +
                short_number(noise.reach_pitches, 2) +
                " pitches. The sigmas allow for it; what helps: " + what_helps);
}

JsonResult json_of(const CornerNoise& noise) {
    return JsonResult()
        .set("sigma_px", noise.sigma_px)
        .set("shared", noise.shared)
        .set("reach_pitches", noise.reach_pitches);
}

}  // namespace stria
