#include <cmath>

#include "host/cli/verbs.h"
#include "host/cli/verify_pictures.h"
#include "host/cli/verify_run.h"
#include "host/core/errors.h"
#include "host/render/plot.h"
#include "host/verify/travel.h"

namespace stria {
namespace {

/// A flat target that travels along its normal: what makers of profile sensors state.
class VerifyProfileVerb final : public VerifyVerb {
  public:
    std::string name() const override { return "verify profile"; }
    std::string summary() const override {
        return "linearity and repeatability over the measuring range, on a travelling flat target";
    }

  private:
    std::vector<std::string> kinds() const override { return {"travel"}; }
    void measure(const ScanPoints& scan, std::mt19937& rng) override {
        if (planes_.size() == artefact_.travelled_mm.size())
            throw Error("the artefact file states " + std::to_string(planes_.size()) +
                        " distances (travelled_mm), one a scan in their order; this scan is more");
        PlaneSearch search;
        search.size_mm = {artefact_.size_mm[0], artefact_.size_mm[1]};
        search.margin_mm = artefact_.margin_mm;
        planes_.push_back(measure_plane(scan, search, rng));
    }

    VerifyOutcome outcome() const override {
        if (planes_.size() != artefact_.travelled_mm.size())
            throw Error("the artefact file states " +
                        std::to_string(artefact_.travelled_mm.size()) +
                        " distances (travelled_mm), one a scan in their order; found " +
                        std::to_string(planes_.size()) + " scans");
        const TravelFigures figures = travel_figures(planes_, artefact_.travelled_mm);
        VerifyOutcome out;
        out.kind = "profile";
        out.procedure = "makers of profile sensors for linearity and repeatability along the range";
        out.artefact = artefact_.name;
        out.figures = {{"linearity_mm", "linearity, greatest error of a place",
                        figures.linearity_mm, artefact_.travelled_expanded_mm,
                        artefact_.mpe_linearity_mm}};
        if (figures.repeats > 0)
            out.figures.push_back({"repeatability_mm", "repeatability of a plane, one sigma",
                                   figures.repeatability_mm, 0, artefact_.mpe_repeatability_mm});
        out.notes = notes(figures);
        for (std::size_t i = 0; i < planes_.size(); ++i) {
            const TravelStep& step = figures.steps[i];
            out.points_used += planes_[i].form.points_used;
            out.rejected += planes_[i].form.rejected;
            out.positions.push_back(JsonResult()
                                        .set("file", names_[i])
                                        .set("travelled_mm", step.true_mm)
                                        .set("measured_mm", step.measured_mm)
                                        .set("error_mm", step.error_mm)
                                        .set("point_sigma_mm", step.point_sigma_mm)
                                        .set("plane_sigma_mm", step.plane_sigma_mm)
                                        .set("points_used", planes_[i].form.points_used));
        }
        out.sections = sections(figures);
        return out;
    }

    std::vector<std::string> notes(const TravelFigures& figures) const {
        std::vector<std::string> notes = common_notes(states_, artefact_);
        notes.push_back("Linearity is " +
                        format_number(100 * figures.linearity_mm / figures.range_mm) +
                        " % of the range of " + format_number(figures.range_mm) +
                        " mm; the scale alone errs by " + format_number(1e6 * figures.scale_error) +
                        " um a metre.");
        if (figures.repeats == 0)
            notes.push_back("No place was scanned twice: repeatability is not known.");
        else if (figures.repeats < 10)
            notes.push_back("Repeatability rests on " + std::to_string(figures.repeats) +
                            " repeats alone.");
        return notes;
    }

    std::vector<ReportSection> sections(const TravelFigures& figures) const {
        ReportTable table{
            "Where the target stood and where its plane was measured, the mean "
            "difference taken out. A point: standard deviation about the plane.",
            {"scan", "travelled (mm)", "measured (mm)", "error (um)", "a point (um)", "points"},
            {}};
        LinePlot plot;
        plot.x = {.label = "travelled", .unit = "mm"};
        plot.y = {.label = "error", .unit = "um", .with_zero = true};
        PlotSeries dots{"", {}, {}, true};
        LinePlot noise = plot;
        noise.y = {.label = "standard deviation of a point", .unit = "um", .with_zero = true};
        PlotSeries points = dots;
        for (std::size_t i = 0; i < planes_.size(); ++i) {
            const TravelStep& step = figures.steps[i];
            table.rows.push_back({names_[i], mm_text(step.true_mm), mm_text(step.measured_mm),
                                  um(step.error_mm), um(step.point_sigma_mm),
                                  std::to_string(planes_[i].form.points_used)});
            dots.x.push_back(step.true_mm);
            dots.y.push_back(1000 * step.error_mm);
            points.x.push_back(step.true_mm);
            points.y.push_back(1000 * step.point_sigma_mm);
        }
        plot.series = {dots};
        noise.series = {points};
        return {{"Along the range",
                 {table, ReportDrawing{"Error of the plane", line_plot_svg(plot)},
                  ReportDrawing{"Noise of single points", line_plot_svg(noise)}}}};
    }

    std::vector<MeasuredPlane> planes_;
};

}  // namespace

std::unique_ptr<Verb> make_verify_profile_verb() { return std::make_unique<VerifyProfileVerb>(); }

}  // namespace stria
