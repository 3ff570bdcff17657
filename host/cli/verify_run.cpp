#include "host/cli/verify_run.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "host/cli/artefact_toml.h"
#include "host/cli/progress.h"
#include "host/cli/quantity.h"
#include "host/cli/scan_input.h"
#include "host/cli/version.h"
#include "host/core/errors.h"
#include "host/core/short_number.h"
#include "host/io/mesh_io.h"

namespace stria {
namespace {

ScanPoints read_scan(const ScanSource& source, const Context& context) {
    if (source.range.empty() && !source.points.empty())
        return scan_points(read_points(source.points, {.mm_per_unit = context.mm_per_unit()}));
    return scan_points(read_range_scan(source, context));
}

JsonResult json_of(const VerifyOutcome& outcome, bool kept) {
    JsonResult json;
    json.set("kind", outcome.kind)
        .set("procedure", "following the procedure of " + outcome.procedure);
    for (const VerifyFigure& figure : outcome.figures) json.set(figure.key, figure.value_mm);
    std::vector<JsonResult> verdicts;
    for (const VerifyFigure& figure : outcome.figures) {
        if (!figure.mpe_mm) continue;
        const Verdict verdict = judge(figure.value_mm, figure.expanded_mm, figure.mpe_mm);
        verdicts.push_back(JsonResult()
                               .set("figure", figure.key)
                               .set("mpe_mm", *figure.mpe_mm)
                               .set("expanded_uncertainty_mm", figure.expanded_mm)
                               .set("verdict", name_of(verdict)));
    }
    return json.set("points_used", outcome.points_used)
        .set("rejected", outcome.rejected)
        .set("verdicts", verdicts)
        .set("kept", kept)
        .set("notes", outcome.notes)
        .set("positions", outcome.positions);
}

/// Says every figure; whether all limits are kept.
bool tell(const Context& context, const VerifyOutcome& outcome) {
    bool kept = true;
    for (const VerifyFigure& figure : outcome.figures) {
        const Verdict verdict = judge(figure.value_mm, figure.expanded_mm, figure.mpe_mm);
        std::string line = figure.name + ": " + um(figure.value_mm) + " um";
        if (figure.expanded_mm > 0) line += ", U " + um(figure.expanded_mm) + " um (k = 2)";
        if (verdict != Verdict::not_asked)
            line += ", permitted " + um(*figure.mpe_mm) + " um: " + name_of(verdict);
        context.say(line);
        kept = kept && (verdict == Verdict::not_asked || verdict == Verdict::accepted);
    }
    for (const std::string& note : outcome.notes) context.say("note: " + note);
    return kept;
}

ReportFigure line_of(const VerifyFigure& figure) {
    ReportFigure line{figure.name, um(figure.value_mm), "um", "", {}};
    if (figure.mpe_mm) {
        const Verdict verdict = judge(figure.value_mm, figure.expanded_mm, figure.mpe_mm);
        line.limit = "|error| + U <= " + um(*figure.mpe_mm) + ", U = " + um(figure.expanded_mm) +
                     ": " + name_of(verdict);
        line.kept = verdict == Verdict::accepted;
    }
    return line;
}

void write_page(const std::string& path, const VerifyOutcome& outcome) {
    Report report;
    report.title =
        "Verification: " + outcome.kind + (outcome.artefact.empty() ? "" : ", " + outcome.artefact);
    report.subtitle = "Following the procedure of " + outcome.procedure +
                      "; no claim of conformity. stria " + std::string(kVersion);
    report.sections = outcome.sections;
    for (const VerifyFigure& figure : outcome.figures) report.summary.push_back(line_of(figure));
    std::string notes;
    for (const std::string& note : outcome.notes) notes += (notes.empty() ? "" : "\n\n") + note;
    if (!notes.empty())
        report.sections.push_back({"What to know about these figures", {ReportText{notes}}});
    write_report(path, report);
}

}  // namespace

void VerifyVerb::declare(Arguments& arguments) {
    arguments.positional("SCAN", arguments_,
                         "scans of the artefact, a position each: range PLY, scan folder, project, "
                         "or points without grid");
    arguments.option("--artefact", artefact_path_, "what its certificate states (artefact.toml)",
                     true);
    arguments.option("--out", page_, "page to write (HTML)");
    declare_more(arguments);
}

int VerifyVerb::run(const Context& context) {
    if (!page_.empty()) context.check_output(page_);
    check_options();
    artefact_ = read_artefact(artefact_path_, kinds());
    const std::vector<ScanSource> sources = resolve_scans(arguments_);
    std::mt19937 rng(context.seed);
    Progress progress(context, "verify", sources.size(), "scans");
    for (const ScanSource& source : sources) {
        const ScanPoints scan = read_scan(source, context);
        names_.push_back(source.name);
        states_.push_back({scan.has_sight(), scan.has_noise(), scan.has_systematic()});
        try {
            measure(scan, rng);
        } catch (const Error& error) {
            throw Error(source.name + ": " + error.what());
        }
        progress.update(names_.size());
    }
    VerifyOutcome result = outcome();
    const bool kept = tell(context, result);
    if (!page_.empty()) {
        write_page(page_, result);
        context.say("page: " + page_);
    }
    context.finish(json_of(result, kept));
    return kept ? 0 : 1;
}

void IncidenceOption::declare(Arguments& arguments) {
    arguments.option("--incidence", text_,
                     "greatest angle between surface normal and line of sight of the points that "
                     "count, 20 to 85 deg");
}

SphereRegionOptions IncidenceOption::region_options() const {
    const double rad = parse_quantity("--incidence", text_, Quantity::angle_rad);
    if (!(rad >= 0.349 && rad <= 1.4836))
        throw Error("--incidence: expected 20 to 85 deg, found " + text_);
    return {rad};
}

std::vector<std::string> common_notes(const std::vector<ScanStates>& scans,
                                      const Artefact& artefact) {
    const auto count = [&](auto&& has) {
        return std::count_if(scans.begin(), scans.end(),
                             [&](const ScanStates& scan) { return !has(scan); });
    };
    const auto of_all = [&](std::ptrdiff_t n) {
        return std::to_string(n) + " of " + std::to_string(scans.size()) + " scans ";
    };
    std::vector<std::string> notes;
    if (const auto n = count([](const ScanStates& s) { return s.sight; }); n > 0)
        notes.push_back(of_all(n) +
                        "do not say where the camera stood: every point of the artefact counts "
                        "there, whatever its incidence.");
    if (const auto n = count([](const ScanStates& s) { return s.noise; }); n > 0)
        notes.push_back(of_all(n) +
                        "state no standard deviation of their points: nothing is predicted for "
                        "them.");
    else if (const auto m = count([](const ScanStates& s) { return s.systematic; }); m > 0)
        notes.push_back(of_all(m) + "state no systematic standard deviation.");
    if (!artefact.temperature && !artefact.diameters.empty())
        notes.push_back(
            "The artefact file states no temperature: calibrated lengths are taken as they are, "
            "and "
            "U holds nothing for temperature.");
    return notes;
}

void set_form(JsonResult& json, const FormFigures& form, const std::string& key) {
    json.set(key, form.form_mm)
        .set("form_all_mm", form.form_all_mm)
        .set("d95_mm", form.d95_mm)
        .set("sigma_mm", form.sigma_mm)
        .set("predicted_sigma_mm", form.predicted_sigma_mm)
        .set("predicted_systematic_mm", form.predicted_systematic_mm)
        .set("expected_form_mm", form.expected_form_mm)
        .set("sigma_ratio", form.sigma_ratio)
        .set("form_ratio", form.form_ratio)
        .set("points_used", form.points_used)
        .set("rejected", form.rejected);
}

std::string falls_short(const std::string& asked, const std::string& found) {
    return "The procedure asks for " + asked + "; " + found + ".";
}

std::string volume_note(const Artefact& artefact, const std::string& what, double length_mm,
                        double least, double most) {
    if (!artefact.volume_diagonal_mm)
        return "The artefact file states no diagonal of the volume (volume_diagonal_mm): whether "
               "the " +
               what + " is large enough for it was not checked.";
    const double share = length_mm / *artefact.volume_diagonal_mm;
    if (share >= least && share <= most) return "";
    const std::string shares = std::isfinite(most)
                                   ? short_number(least) + " to " + short_number(most)
                                   : "at least " + short_number(least);
    return falls_short("a " + what + " of " + shares + " of the volume's diagonal",
                       "this one has " + format_number(share));
}

std::string mm_text(double mm) {
    char text[40];
    std::snprintf(text, sizeof text, "%.4f", mm);
    return text;
}

std::string um(double mm) {
    const double value = 1000 * mm;
    if (!(std::abs(value) < 9.995)) return format_number(value, 3);
    char text[16];
    std::snprintf(text, sizeof text, "%.2f", std::round(100 * value) / 100 + 0.0);  // no -0.00
    return text;
}

}  // namespace stria
