#pragma once
#include <optional>
#include <string>
#include <vector>

#include "host/advise/changes.h"
#include "host/advise/design.h"
#include "host/cli/json_result.h"

namespace stria {

/// Advice with what it is about.
struct ReportedAdvice {
    AdvisedScanner scanner;
    Advice advice;
    std::vector<Change> changes;
    /// Of a design with a wanted sigma only.
    std::optional<double> wanted_sigma_z_mm, baseline_for_sigma_mm;
    double best_sigma_z_mm = 0;
};

/// Lines for people: the scanner, what to expect, why, and what to change first.
std::vector<std::string> advice_text(const ReportedAdvice& reported);

/// The same as numbers; host/cli/README.md lists the keys.
JsonResult advice_json(const ReportedAdvice& reported);

}  // namespace stria
