#include "host/cli/lens_report.h"

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

}  // namespace stria
