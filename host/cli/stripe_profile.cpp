#include "host/cli/stripe_profile.h"
#include "firmware/core/median.h"

#include <algorithm>
#include <cstdio>
#include <limits>

namespace stria {
namespace {

constexpr int kBands = 8;

}  // namespace

StripeProfile::StripeProfile(int length)
    : length_(std::max(length, 1)), values_(static_cast<std::size_t>(std::min(kBands, length_))) {}

void StripeProfile::add(const Pulse& peak) {
    const int row = std::clamp(static_cast<int>(peak.v), 0, length_ - 1);
    const int count = static_cast<int>(values_.size());
    Values& band = values_[static_cast<std::size_t>(row * count / length_)];
    if (peak.flags != 0) {
        ++band.flagged;
        return;
    }
    band.width.push_back(peak.width);
    band.sigma.push_back(peak.sigma);
    band.amplitude.push_back(peak.amplitude);
}

std::vector<StripeProfile::Band> StripeProfile::bands() const {
    std::vector<Band> out;
    const int count = static_cast<int>(values_.size());
    for (int i = 0; i < count; ++i) {
        const Values& of = values_[static_cast<std::size_t>(i)];
        constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
        Band band;
        band.from = (i * length_ + count - 1) / count;
        band.to = ((i + 1) * length_ + count - 1) / count;
        band.flagged = of.flagged;
        band.peaks = of.flagged + of.width.size();
        band.width = median(of.width, kNone);
        band.sigma = median(of.sigma, kNone);
        band.amplitude = median(of.amplitude, kNone);
        out.push_back(band);
    }
    return out;
}

std::string StripeProfile::table(const std::string& rows, const std::string& unit,
                                 double scale) const {
    char line[160];
    std::snprintf(line, sizeof line,
                  "along the stripe, medians of unflagged:\n%12s %9s %9s %12s %12s %10s",
                  rows.c_str(), "peaks", "flagged", ("width " + unit).c_str(),
                  ("sigma " + unit).c_str(), "height DN");
    std::string text = line;
    for (const Band& band : bands()) {
        const std::string range = std::to_string(band.from) + "-" + std::to_string(band.to - 1);
        std::snprintf(line, sizeof line, "\n%12s %9zu %9zu %12.4g %12.4g %10.4g", range.c_str(),
                      band.peaks, band.flagged, band.width * scale, band.sigma * scale,
                      band.amplitude);
        text += line;
    }
    return text;
}

std::vector<JsonResult> StripeProfile::json(double scale) const {
    std::vector<JsonResult> out;
    for (const Band& band : bands()) {
        JsonResult result;
        result.set("from", band.from).set("to", band.to);
        result.set("peaks", band.peaks).set("flagged", band.flagged);
        result.set("width", band.width * scale).set("sigma", band.sigma * scale);
        result.set("amplitude", band.amplitude);
        out.push_back(result);
    }
    return out;
}

}  // namespace stria
