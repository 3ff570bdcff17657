#include <algorithm>
#include <cmath>

#include "host/cli/verbs.h"
#include "host/cli/verify_pictures.h"
#include "host/cli/verify_run.h"
#include "host/verify/beam.h"

namespace stria {
namespace {

constexpr std::size_t kPositionsAsked = 7;

JsonResult json_of(const MeasuredSphere& fixed, const MeasuredSphere& free) {
    JsonResult json;
    set_form(json, free.form);
    return json.set("centre_mm", Eigen::VectorXd(fixed.centre))
        .set("diameter_mm", free.diameter_mm)
        .set("diameter_sigma_mm", free.diameter_sigma_mm)
        .set("coverage", free.coverage);
}

/// The sphere-spacing error: two spheres, fitted with their calibrated radii.
class VerifyBarVerb final : public VerifyVerb {
  public:
    std::string name() const override { return "verify bar"; }
    std::string summary() const override { return "sphere-spacing error on a calibrated ball bar"; }

  private:
    struct Position {
        MeasuredBeam beam;
        BeamLength spacing;
    };

    void declare_more(Arguments& arguments) override { incidence_.declare(arguments); }
    std::vector<std::string> kinds() const override { return {"bar"}; }
    void check_options() override { options_ = incidence_.region_options(); }
    void measure(const ScanPoints& scan, std::mt19937& rng) override {
        MeasuredBeam beam = measure_beam(scan, artefact_, options_, rng);
        const BeamLength spacing = centre_distance(beam, artefact_, 0, 1);
        positions_.push_back({std::move(beam), spacing});
    }

    VerifyOutcome outcome() const override {
        VerifyOutcome out;
        out.kind = "bar";
        out.procedure = "VDI/VDE 2634-2 for the sphere-spacing error (SD)";
        out.artefact = artefact_.name;
        const auto worst = std::max_element(
            positions_.begin(), positions_.end(), [](const Position& a, const Position& b) {
                return std::abs(a.spacing.error_mm()) < std::abs(b.spacing.error_mm());
            });
        out.figures = {{"spacing_mm", "sphere-spacing error SD, worst position",
                        worst->spacing.error_mm(), worst->spacing.expanded_mm,
                        artefact_.mpe_spacing_mm}};
        out.notes = notes();
        for (std::size_t i = 0; i < positions_.size(); ++i) {
            const Position& position = positions_[i];
            std::vector<JsonResult> spheres;
            for (std::size_t k = 0; k < 2; ++k) {
                out.points_used += position.beam.fixed[k].form.points_used;
                out.rejected += position.beam.fixed[k].form.rejected;
                spheres.push_back(json_of(position.beam.fixed[k], position.beam.free[k]));
            }
            out.positions.push_back(
                JsonResult()
                    .set("file", names_[i])
                    .set("spacing_mm", position.spacing.error_mm())
                    .set("distance_mm", position.spacing.measured_mm)
                    .set("calibrated_mm", position.spacing.calibrated_mm)
                    .set("expanded_uncertainty_mm", position.spacing.expanded_mm)
                    .set("spheres", spheres));
        }
        out.sections = sections();
        return out;
    }

    std::vector<std::string> notes() const {
        std::vector<std::string> notes = common_notes(states_, artefact_);
        if (positions_.size() < kPositionsAsked)
            notes.push_back(falls_short("7 positions along edges and diagonals of the volume",
                                        "these are " + std::to_string(positions_.size())));
        if (const auto note = volume_note(artefact_, "bar", artefact_.lengths[0].mm, 0.3);
            !note.empty())
            notes.push_back(note);
        notes.push_back(kIndependentNote);
        return notes;
    }

    std::vector<ReportSection> sections() const {
        ReportTable table{
            "Distances of the centres, spheres fitted with their calibrated radii, at most 3 of "
            "1000 points rejected. The size of each sphere, its radius free, stands beside it.",
            {"scan", "distance (mm)", "calibrated (mm)", "SD (um)", "U (um)", "size 1 (um)",
             "size 2 (um)", "points 1", "points 2"},
            {}};
        std::vector<double> errors;
        std::vector<Eigen::Vector3d> places;
        std::vector<const FormFigures*> forms;
        std::vector<std::string> spheres;
        ReportPictures maps;
        std::vector<float> residuals;
        for (const Position& position : positions_)
            for (const MeasuredSphere& sphere : position.beam.fixed)
                add_residuals(sphere.form, residuals);
        maps.scale = residual_scale(residuals);
        for (std::size_t i = 0; i < positions_.size(); ++i) {
            const Position& position = positions_[i];
            std::vector<std::string> row = {names_[i], mm_text(position.spacing.measured_mm),
                                            mm_text(position.spacing.calibrated_mm),
                                            um(position.spacing.error_mm()),
                                            um(position.spacing.expanded_mm)};
            const auto both = [&](auto&& text) {
                for (std::size_t k = 0; k < 2; ++k) row.push_back(text(k));
            };
            const MeasuredBeam& beam = position.beam;
            both([&](std::size_t k) {
                return um(beam.free[k].diameter_mm -
                          at_temperature(artefact_, artefact_.diameters[k]).mm);
            });
            both([&](std::size_t k) { return std::to_string(beam.fixed[k].form.points_used); });
            table.rows.push_back(row);
            errors.push_back(position.spacing.error_mm());
            for (std::size_t k = 0; k < 2; ++k) {
                places.push_back(beam.fixed[k].centre);
                forms.push_back(&beam.fixed[k].form);
                spheres.push_back(names_[i] + ", sphere " + std::to_string(k + 1));
                maps.pictures.push_back({spheres.back(), residual_map(beam.fixed[k], *maps.scale)});
            }
        }
        return {
            {"By position",
             {table,
              by_position("Sphere-spacing error", "SD", errors, {}, artefact_.mpe_spacing_mm),
              noise_table(spheres, forms)}},
            {"Residuals on the spheres, radius as calibrated", {maps, residual_histogram(forms)}},
            {"Where in the volume", places_in_volume(places)}};
    }

    IncidenceOption incidence_;
    SphereRegionOptions options_;
    std::vector<Position> positions_;
};

}  // namespace

std::unique_ptr<Verb> make_verify_bar_verb() { return std::make_unique<VerifyBarVerb>(); }

}  // namespace stria
