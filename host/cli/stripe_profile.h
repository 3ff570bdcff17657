#pragma once
#include <string>
#include <vector>

#include "firmware/core/pulse.h"
#include "host/cli/json_result.h"

namespace stria {

/// Width and sigma of what was found, in bands along the stripe: a line out of focus at one end, a
/// vignetted lens or a worn beam shows here.
class StripeProfile {
  public:
    /// @param length  rows along the stripe
    explicit StripeProfile(int length);

    /// Flagged peaks are counted, but not measured.
    void add(const Pulse& peak);

    struct Band {
        int from = 0, to = 0;  ///< rows, `to` excluded
        std::size_t peaks = 0, flagged = 0;
        double width = 0, sigma = 0, amplitude = 0;  ///< medians of the unflagged; NaN without one
    };
    std::vector<Band> bands() const;
    /// A table for people. `rows` names what is counted along the stripe, `unit` that of width and
    /// sigma, which are shown times `scale`.
    std::string table(const std::string& rows, const std::string& unit, double scale = 1) const;
    std::vector<JsonResult> json(double scale = 1) const;

  private:
    struct Values {
        std::vector<float> width, sigma, amplitude;
        std::size_t flagged = 0;
    };
    int length_ = 0;
    std::vector<Values> values_;
};

}  // namespace stria
