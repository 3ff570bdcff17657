#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/cli/verbs.h"
#include "host/cli/verify_pictures.h"
#include "host/cli/verify_run.h"
#include "host/verify/probing.h"

namespace stria {
namespace {

constexpr std::size_t kPositionsAsked = 10;

JsonResult json_of(const std::string& file, const ProbingPosition& position) {
    const MeasuredSphere& sphere = position.sphere;
    JsonResult json;
    json.set("file", file);
    set_form(json, sphere.form);
    return json.set("size_mm", position.size_mm)
        .set("size_expanded_uncertainty_mm", position.size_expanded_mm)
        .set("diameter_mm", sphere.diameter_mm)
        .set("diameter_sigma_mm", sphere.diameter_sigma_mm)
        .set("centre_mm", Eigen::VectorXd(sphere.centre))
        .set("coverage", sphere.coverage)
        .set("cap_rad", sphere.cap_rad)
        .set("too_flat", sphere.region.too_flat)
        .set("beside", sphere.region.beside);
}

class VerifySphereVerb final : public VerifyVerb {
  public:
    std::string name() const override { return "verify sphere"; }
    std::string summary() const override {
        return "probing errors of form and size on a calibrated sphere";
    }

  private:
    void declare_more(Arguments& arguments) override { incidence_.declare(arguments); }
    std::vector<std::string> kinds() const override { return {"sphere"}; }
    void check_options() override { options_ = incidence_.region_options(); }
    void measure(const ScanPoints& scan, std::mt19937& rng) override {
        positions_.push_back(probe_sphere(scan, artefact_, options_, rng));
    }

    VerifyOutcome outcome() const override {
        VerifyOutcome out;
        out.kind = "sphere";
        out.procedure = "VDI/VDE 2634-2 for the probing errors of form (PF) and size (PS)";
        out.artefact = artefact_.name;
        const auto form = std::max_element(positions_.begin(), positions_.end(),
                                           [](const auto& a, const auto& b) {
                                               return a.sphere.form.form_mm < b.sphere.form.form_mm;
                                           });
        const auto size = std::max_element(
            positions_.begin(), positions_.end(),
            [](const auto& a, const auto& b) { return std::abs(a.size_mm) < std::abs(b.size_mm); });
        out.figures = {{"form_mm", "probing error of form PF, worst position",
                        form->sphere.form.form_mm, artefact_.form_mm, artefact_.mpe_form_mm},
                       {"size_mm", "probing error of size PS, worst position", size->size_mm,
                        size->size_expanded_mm, artefact_.mpe_size_mm}};
        out.notes = notes();
        for (std::size_t i = 0; i < positions_.size(); ++i) {
            out.points_used += positions_[i].sphere.form.points_used;
            out.rejected += positions_[i].sphere.form.rejected;
            out.positions.push_back(json_of(names_[i], positions_[i]));
        }
        out.sections = sections();
        return out;
    }

    std::vector<std::string> notes() const {
        std::vector<std::string> notes = common_notes(states_, artefact_);
        if (positions_.size() < kPositionsAsked)
            notes.push_back(falls_short("at least 10 positions that fill the volume",
                                        "these are " + std::to_string(positions_.size())));
        if (const auto note = volume_note(artefact_, "sphere", artefact_.diameters[0].mm, 0.1, 0.2);
            !note.empty())
            notes.push_back(note);
        if (artefact_.form_mm <= 0) notes.push_back(kFormNote);
        notes.push_back(kIndependentNote);
        return notes;
    }

    std::vector<ReportSection> sections() const {
        ReportTable table{
            "Form PF and size PS of the least-squares sphere, free radius, at most 3 of 1000 "
            "points "
            "rejected. The form expected is what random noise of the predicted size alone shows.",
            {"scan", "PF (um)", "expected (um)", "PF, none rejected (um)", "D95 (um)", "PS (um)",
             "U of PS (um)", "points", "rejected", "cap (deg)", "of the sphere (%)"},
            {}};
        std::vector<double> forms, expected, sizes;
        std::vector<Eigen::Vector3d> places;
        std::vector<const FormFigures*> figures;
        std::vector<float> residuals;
        for (std::size_t i = 0; i < positions_.size(); ++i) {
            const MeasuredSphere& s = positions_[i].sphere;
            const FormFigures& f = s.form;
            table.rows.push_back({names_[i], um(f.form_mm), um(f.expected_form_mm),
                                  um(f.form_all_mm), um(f.d95_mm), um(positions_[i].size_mm),
                                  um(positions_[i].size_expanded_mm), std::to_string(f.points_used),
                                  std::to_string(f.rejected),
                                  format_number(s.cap_rad * 180 / std::numbers::pi),
                                  format_number(100 * s.coverage)});
            forms.push_back(f.form_mm);
            expected.push_back(f.expected_form_mm);
            sizes.push_back(positions_[i].size_mm);
            places.push_back(s.centre);
            figures.push_back(&f);
            add_residuals(f, residuals);
        }
        ReportPictures maps;
        maps.scale = residual_scale(residuals);
        for (std::size_t i = 0; i < positions_.size(); ++i)
            maps.pictures.push_back({names_[i], residual_map(positions_[i].sphere, *maps.scale)});
        ReportSection where{"Where in the volume", places_in_volume(places)};
        return {
            {"By position",
             {table,
              by_position("Probing error of form", "PF", forms, expected, artefact_.mpe_form_mm),
              by_position("Probing error of size", "PS", sizes, {}, artefact_.mpe_size_mm),
              noise_table(names_, figures)}},
            {"Residuals on the sphere",
             {ReportText{"Each as seen along the middle of the measured part; the distance from "
                         "the centre is the angle on the sphere. A pattern that repeats is an "
                         "error of the scanner, even colour is noise."},
              maps, residual_histogram(figures)}},
            where};
    }

    IncidenceOption incidence_;
    SphereRegionOptions options_;
    std::vector<ProbingPosition> positions_;
};

}  // namespace

std::unique_ptr<Verb> make_verify_sphere_verb() { return std::make_unique<VerifySphereVerb>(); }

}  // namespace stria
