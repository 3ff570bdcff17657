#include "host/cli/drift_check.h"

#include <filesystem>
#include <random>

#include "host/cli/artefact_toml.h"
#include "host/cli/verify_run.h"
#include "host/core/errors.h"
#include "host/core/short_number.h"
#include "host/geometry/range_grid.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

constexpr int kEdgeCells = 3;

/// Without what is next to the border of a surface: there the stripe is cut, and its middle says
/// more of the cut than of the scanner.
RangeImage without_edges(RangeImage image) {
    const auto border = border_distance(image, range_triangles(image), kEdgeCells + 1);
    for (std::size_t cell = 0; cell < image.cell_count(); ++cell)
        if (border[cell] <= kEdgeCells) image.mask[cell] = 0;
    return image;
}

ShapeCheck measured(const RangeImage& image, const Artefact& artefact, unsigned seed) {
    std::mt19937 rng(seed);
    const ScanPoints scan = scan_points(without_edges(image));
    return artefact.diameters.empty() ? check_plane(scan, artefact, rng)
                                      : check_sphere(scan, artefact, {}, rng);
}

JsonResult json_of(const ShapeCheck& check, const Drift& drift, bool by_reference) {
    std::vector<JsonResult> figures;
    for (std::size_t i = 0; i < check.figures.size(); ++i)
        figures.push_back(JsonResult()
                              .set("figure", check.figures[i].key)
                              .set("off_mm", drift.off_mm[i])
                              .set("expected_mm", drift.expected_mm[i]));
    JsonResult json;
    json.set("kind", check.kind)
        .set("against", by_reference ? "reference" : "certificate")
        .set("figures", figures);
    if (by_reference) json.set("p_value", drift.p_value).set("drifted", drift.has_drifted());
    return json;
}

}  // namespace

void DriftCheck::declare(Arguments& arguments) {
    arguments.option("--check", path_,
                     "artefact.toml of a sphere or plane in view (as stria verify takes it): tells "
                     "drift above 2 sigma from the project's check.toml");
    arguments.flag("--check-as-reference", becomes_reference_,
                   "with --check: later checks of the project are compared with this one");
}

void DriftCheck::read() {
    if (!is_asked()) {
        if (becomes_reference_) throw Error("--check-as-reference: expected --check as well");
        return;
    }
    artefact_ = read_artefact(path_, {"sphere", "plane"});
}

std::optional<ScanNotes> DriftCheck::reference(const Context& context, const std::string& path,
                                               const ScanNotes& notes) const {
    if (becomes_reference_ || !std::filesystem::exists(path)) return {};
    ScanNotes found = read_scan_notes(path);
    if (!found.check)
        throw FileError(path, "", "has no [check]: expected that of a scan with --check");
    const std::string kind = artefact_.diameters.empty() ? "plane" : "sphere";
    if (found.model_hash == notes.model_hash && found.artefact == artefact_.name &&
        found.check->kind == kind)
        return found;
    context.say("check: " + path + " is of another " +
                (found.model_hash != notes.model_hash ? "calibration" : "artefact") +
                ": not compared with it");
    return {};
}

void DriftCheck::run(const Context& context, const RangeImage& image,
                     const std::string& reference_path, ScanNotes& notes,
                     JsonResult& result) const {
    const auto before = reference(context, reference_path, notes);
    notes.artefact = artefact_.name;
    notes.check = measured(image, artefact_, context.seed);
    const Drift drift = judge_drift(*notes.check, before ? &*before->check : nullptr);
    const char* against = before ? "since the reference" : "from the artefact's certificate";
    for (std::size_t i = 0; i < drift.off_mm.size(); ++i)
        context.say("check: " + notes.check->figures[i].name + " off by " + um(drift.off_mm[i]) +
                    " um " + against + ", expected " + um(drift.expected_mm[i]) + " um (1 sigma)");
    if (!before && !becomes_reference_)
        context.say(
            "check: without a reference drift is not judged, because surface and pixel size make "
            "an artefact seem off as well: --check-as-reference on a scan right after the "
            "calibration");
    if (before && drift.has_drifted())
        context.say(
            "warning: the check artefact is off by more than 2 sigma of what noise and "
            "calibration expect (p " +
            short_number(drift.p_value, 2) +
            "): the scanner has drifted, or the artefact's surface is not what it was; let "
            "it warm up, or calibrate again");
    result.set("check", json_of(*notes.check, drift, before.has_value()));
    if (becomes_reference_) {
        write_whole_file(reference_path, format_scan_notes(notes));
        context.say("check: " + reference_path + " is the reference now");
    }
}

}  // namespace stria
