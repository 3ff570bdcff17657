#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/cli/verbs.h"
#include "host/cli/verify_pictures.h"
#include "host/cli/verify_run.h"
#include "host/verify/flatness.h"

namespace stria {
namespace {

constexpr std::size_t kPositionsAsked = 6;

/// Residuals as seen along the plane's normal, its longer side to the right.
ColourImage residual_map(const MeasuredPlane& plane, const ColourScale& scale) {
    const Eigen::Vector3d across = plane.normal.cross(plane.along);
    const double height = plane.size_mm.y() / plane.size_mm.x();
    std::vector<Eigen::Vector2d> places;
    std::vector<float> values;
    for (std::size_t i = 0; i < plane.points.positions.size(); ++i) {
        const Eigen::Vector3d off = plane.points.positions[i] - plane.centre;
        places.emplace_back(0.5 + off.dot(plane.along) / plane.size_mm.x(),
                            height / 2 - off.dot(across) / plane.size_mm.x());
        values.push_back(static_cast<float>(1000 * plane.form.residuals_mm[i]));
    }
    return scattered_picture(places, values, scale, height);
}

class VerifyPlaneVerb final : public VerifyVerb {
  public:
    std::string name() const override { return "verify plane"; }
    std::string summary() const override { return "flatness error on a calibrated plane"; }

  private:
    std::vector<std::string> kinds() const override { return {"plane"}; }
    void measure(const ScanPoints& scan, std::mt19937& rng) override {
        PlaneSearch search;
        search.size_mm = {artefact_.size_mm[0], artefact_.size_mm[1]};
        search.margin_mm = artefact_.margin_mm;
        positions_.push_back(measure_plane(scan, search, rng));
    }

    VerifyOutcome outcome() const override {
        VerifyOutcome out;
        out.kind = "plane";
        out.procedure = "VDI/VDE 2634-2 for the flatness error (F)";
        out.artefact = artefact_.name;
        const auto worst = std::max_element(positions_.begin(), positions_.end(),
                                            [](const MeasuredPlane& a, const MeasuredPlane& b) {
                                                return a.form.form_mm < b.form.form_mm;
                                            });
        out.figures = {{"flatness_mm", "flatness error F, worst position", worst->form.form_mm,
                        artefact_.form_mm, artefact_.mpe_form_mm}};
        out.notes = common_notes(states_, artefact_);
        if (artefact_.form_mm <= 0) out.notes.push_back(kFormNote);
        if (positions_.size() < kPositionsAsked)
            out.notes.push_back(
                falls_short("6 positions, oblique ones and such off the centre among them",
                            "these are " + std::to_string(positions_.size())));
        if (artefact_.size_mm[1] < 50)
            out.notes.push_back(
                falls_short("a plane at least 50 mm wide",
                            "this one has " + format_number(artefact_.size_mm[1]) + " mm"));
        if (const auto note = volume_note(artefact_, "plane", artefact_.size_mm[0], 0.5);
            !note.empty())
            out.notes.push_back(note);
        for (std::size_t i = 0; i < positions_.size(); ++i) {
            const MeasuredPlane& plane = positions_[i];
            out.points_used += plane.form.points_used;
            out.rejected += plane.form.rejected;
            JsonResult json;
            json.set("file", names_[i]);
            set_form(json, plane.form, "flatness_mm");
            out.positions.push_back(json.set("centre_mm", Eigen::VectorXd(plane.centre))
                                        .set("normal", Eigen::VectorXd(plane.normal))
                                        .set("size_mm", Eigen::VectorXd(plane.size_mm))
                                        .set("used_mm", Eigen::VectorXd(plane.used_mm))
                                        .set("incidence_rad", plane.incidence_rad)
                                        .set("beside", plane.beside));
        }
        out.sections = sections();
        return out;
    }

    std::vector<ReportSection> sections() const {
        ReportTable table{
            "Least-squares plane, at most 3 of 1000 points rejected, " +
                format_number(artefact_.margin_mm) +
                " mm along the border left out. The flatness expected is what random noise of the "
                "predicted size alone shows.",
            {"scan", "used (mm)", "F (um)", "expected (um)", "F, none rejected (um)", "D95 (um)",
             "points", "rejected", "incidence (deg)"},
            {}};
        std::vector<double> flatness, expected;
        std::vector<Eigen::Vector3d> places;
        std::vector<const FormFigures*> forms;
        std::vector<float> residuals;
        for (const MeasuredPlane& plane : positions_) add_residuals(plane.form, residuals);
        ReportPictures maps;
        maps.scale = residual_scale(residuals);
        for (std::size_t i = 0; i < positions_.size(); ++i) {
            const MeasuredPlane& plane = positions_[i];
            const FormFigures& f = plane.form;
            table.rows.push_back(
                {names_[i],
                 format_number(plane.used_mm.x()) + " x " + format_number(plane.used_mm.y()),
                 um(f.form_mm), um(f.expected_form_mm), um(f.form_all_mm), um(f.d95_mm),
                 std::to_string(f.points_used), std::to_string(f.rejected),
                 format_number(plane.incidence_rad * 180 / std::numbers::pi)});
            flatness.push_back(f.form_mm);
            expected.push_back(f.expected_form_mm);
            places.push_back(plane.centre);
            forms.push_back(&f);
            maps.pictures.push_back({names_[i], residual_map(plane, *maps.scale)});
        }
        return {
            {"By position",
             {table, by_position("Flatness error", "F", flatness, expected, artefact_.mpe_form_mm),
              noise_table(names_, forms)}},
            {"Residuals on the plane",
             {ReportText{"Each as seen along its normal, the longer side to the right. A "
                         "pattern that repeats is an error of the scanner, even colour is "
                         "noise."},
              maps, residual_histogram(forms)}},
            {"Where in the volume", places_in_volume(places)}};
    }

    std::vector<MeasuredPlane> positions_;
};

}  // namespace

std::unique_ptr<Verb> make_verify_plane_verb() { return std::make_unique<VerifyPlaneVerb>(); }

}  // namespace stria
