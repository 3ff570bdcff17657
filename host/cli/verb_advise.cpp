#include <algorithm>

#include "host/cli/advice_report.h"
#include "host/cli/advise_options.h"
#include "host/cli/verbs.h"
#include "host/core/errors.h"
#include "host/io/model_io.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

/// The sweep advised, as plan.toml holds it.
ScanPlan plan_of(const Advice& advice) {
    ScanPlan plan;
    plan.mode = advice.mode;
    plan.from = advice.range.from;
    plan.to = advice.range.to;
    plan.step = advice.step;
    plan.exposures_us = {advice.exposure_us};
    plan.max_emission_s = std::clamp(1.5 * advice.seconds, plan.max_emission_s, 3600.0);
    if (const std::string why = validate(plan); !why.empty())
        throw Error("the advised sweep is no plan: " + why);
    return plan;
}

class AdviseVerb final : public Verb {
  public:
    std::string name() const override { return "advise"; }
    std::string summary() const override {
        return "from field, distance, camera and laser to baseline, expected sigma, greatest step";
    }
    void declare(Arguments& arguments) override {
        options_.declare(arguments);
        arguments.option("--plan", plan_,
                         "plan.toml to write with the step that the advice is for");
    }

    int run(const Context& context) override {
        if (!plan_.empty()) context.check_output(plan_);
        const ReportedAdvice reported =
            options_.has_existing() ? of_existing(context) : of_design(context);
        for (const std::string& line : advice_text(reported)) context.say(line);
        JsonResult result = advice_json(reported);
        if (!plan_.empty()) {
            write_whole_file(plan_, format_plan(plan_of(reported.advice)));
            context.say(plan_ + ": written");
            result.set("plan", plan_);
        }
        context.finish(result);
        return 0;
    }

  private:
    ReportedAdvice of_design(const Context& context) const {
        const ScannerDesign design = options_.design(context);
        DesignAdvice advised = advise_design(design);
        ReportedAdvice reported;
        reported.changes = possible_changes(advised.scanner, advised.advice);
        reported.wanted_sigma_z_mm = design.sigma_z_mm;
        reported.baseline_for_sigma_mm = advised.baseline_for_sigma_mm;
        reported.best_sigma_z_mm = advised.best_sigma_z_mm;
        reported.scanner = std::move(advised.scanner);
        reported.advice = std::move(advised.advice);
        return reported;
    }

    ReportedAdvice of_existing(const Context& context) const {
        ReportedAdvice reported;
        reported.scanner = options_.existing(context);
        reported.advice = advise(reported.scanner);
        reported.changes = possible_changes(reported.scanner, reported.advice);
        return reported;
    }

    AdviseOptions options_;
    std::string plan_;
};

}  // namespace

std::unique_ptr<Verb> make_advise_verb() { return std::make_unique<AdviseVerb>(); }

}  // namespace stria
