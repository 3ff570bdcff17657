#include "host/advise/changes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <numbers>

#include "host/core/errors.h"

namespace stria {
namespace {

constexpr double kLeastGain = 0.005;
constexpr double kBlue_nm = 450;

std::string with_number(const char* format, double number) {
    char text[120];
    std::snprintf(text, sizeof text, format, number);
    return text;
}

struct Trial {
    std::string what;
    AdvisedScanner scanner;
};

Trial trial(const AdvisedScanner& from, std::string what,
            const std::function<void(AdvisedScanner&)>& change) {
    Trial made{std::move(what), from};
    change(made.scanner);
    return made;
}

std::vector<Trial> trials_of(const AdvisedScanner& from, const Advice& now) {
    std::vector<Trial> trials;
    for (const double factor : {std::numbers::sqrt2, 1 / std::numbers::sqrt2}) {
        const double n = from.sensor.f_number * factor;
        trials.push_back(trial(
            from,
            with_number(factor > 1 ? "close the lens to f/%.2g" : "open the lens to f/%.2g", n),
            [&](AdvisedScanner& s) { s.sensor.f_number = n; }));
    }
    trials.push_back(trial(from,
                           with_number("double the laser's power to %.3g mW", 2 * from.power_mw),
                           [](AdvisedScanner& s) { s.power_mw *= 2; }));
    if (now.near.saturated || now.middle.saturated || now.far.saturated)
        trials.push_back(trial(from, "expose so that the brightest surface fits",
                               [](AdvisedScanner& s) { s.sensor.exposure_us.reset(); }));
    if (from.channel.sheet.wavelength_nm > 1.05 * kBlue_nm)
        trials.push_back(trial(from, "take a blue laser (450 nm)", [](AdvisedScanner& s) {
            s.channel.sheet.wavelength_nm = kBlue_nm;
        }));
    trials.push_back(trial(from, "halve the step: twice the frames and the time",
                           [&](AdvisedScanner& s) { s.step = now.step / 2; }));
    if (now.advised_step < now.step)
        trials.push_back(trial(from, "take the advised step",
                               [&](AdvisedScanner& s) { s.step = now.advised_step; }));
    if (from.surface.speckle_contrast > 0.75)
        trials.push_back(
            trial(from, "spray the part: a coat that depolarises (contrast 0.71)",
                  [](AdvisedScanner& s) { s.surface.speckle_contrast *= std::sqrt(0.5); }));
    for (const WaistChoice& choice : now.waists)
        if (choice.name == "at the mirror")
            trials.push_back(trial(
                from,
                with_number("put the waist (sigma %.3g mm) at the mirror", choice.waist_sigma_mm),
                [&](AdvisedScanner& s) {
                    const Crossing& c = now.middle.crossing;
                    s.channel.sheet.waist_sigma_mm = choice.waist_sigma_mm;
                    s.channel.sheet.waist_at_mm = c.laser_mm - c.pivot_mm;
                }));
    return trials;
}

}  // namespace

std::vector<Change> possible_changes(const AdvisedScanner& scanner, const Advice& now) {
    std::vector<Change> changes;
    const double z_now = now.worst_z_mm();
    for (Trial& t : trials_of(scanner, now)) {
        // One number at a time: the step stays, unless it is what changes.
        if (!t.scanner.step) t.scanner.step = now.step;
        if (!validate(t.scanner).empty()) continue;
        Advice then;
        try {
            then = advise(t.scanner);
        } catch (const Error&) {
            continue;  // a narrower stripe than the step, for instance
        }
        Change change;
        change.what = t.what;
        change.z_mm = then.worst_z_mm();
        change.gain = 1 - change.z_mm / z_now;
        change.edge_ratio = then.middle.footprint.sigma_mm() / then.middle.sigma_b_mm;
        change.seconds = then.seconds;
        if (std::abs(change.gain) >= kLeastGain) changes.push_back(change);
    }
    std::stable_sort(changes.begin(), changes.end(),
                     [](const Change& a, const Change& b) { return a.gain > b.gain; });
    return changes;
}

}  // namespace stria
