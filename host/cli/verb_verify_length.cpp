#include <algorithm>
#include <cmath>
#include <limits>

#include "host/cli/verbs.h"
#include "host/cli/verify_pictures.h"
#include "host/cli/verify_run.h"
#include "host/render/plot.h"
#include "host/verify/beam.h"

namespace stria {
namespace {

constexpr std::size_t kLinesAsked = 7, kLengthsAsked = 5;

/// Lengths over pairs of spheres of a bar or beam, as scanned: diameters and centres free.
class VerifyLengthVerb final : public VerifyVerb {
  public:
    std::string name() const override { return "verify length"; }
    std::string summary() const override {
        return "length errors over the spheres of a calibrated bar or beam";
    }

  private:
    struct Line {
        MeasuredBeam beam;
        std::vector<BeamLength> lengths;
    };

    void declare_more(Arguments& arguments) override { incidence_.declare(arguments); }
    std::vector<std::string> kinds() const override { return {"bar", "beam"}; }
    void check_options() override { options_ = incidence_.region_options(); }
    void measure(const ScanPoints& scan, std::mt19937& rng) override {
        Line line{measure_beam(scan, artefact_, options_, rng), {}};
        for (std::size_t to = 1; to < artefact_.diameters.size(); ++to)
            for (std::size_t from = 0; from < to; ++from)
                line.lengths.push_back(length_over(line.beam, artefact_, from, to));
        lines_.push_back(std::move(line));
    }

    std::optional<double> limit_at(double length_mm) const {
        if (!artefact_.mpe_length_mm) return {};
        return *artefact_.mpe_length_mm + artefact_.mpe_length_per_mm * length_mm;
    }
    std::optional<double> limit_of(const BeamLength& length) const {
        return limit_at(length.calibrated_mm);
    }
    /// What is permitted over the lengths of the plot, both ways.
    PlotSeries permitted(const std::vector<double>& lengths_mm) const {
        const auto [least, most] = std::minmax_element(lengths_mm.begin(), lengths_mm.end());
        const double from = 0.9 * *least, to = 1.1 * *most;
        const double low = 1000 * *limit_at(from), high = 1000 * *limit_at(to);
        const double parted = std::numeric_limits<double>::quiet_NaN();
        return {"permitted", {from, to, to, from, to}, {low, high, parted, -low, -high}};
    }
    /// How badly a length stands: by what its limit leaves, or without one by its error.
    double badness(const BeamLength& length) const {
        const std::optional<double> limit = limit_of(length);
        return std::abs(length.error_mm()) + (limit ? length.expanded_mm - *limit : 0.0);
    }

    VerifyOutcome outcome() const override {
        VerifyOutcome out;
        out.kind = "length";
        out.procedure =
            "ISO 10360-13 and VDI/VDE 2634-3 for length measurement errors (E), lengths over "
            "pairs of spheres";
        out.artefact = artefact_.name;
        const BeamLength* worst = &lines_.front().lengths.front();
        for (const Line& line : lines_)
            for (const BeamLength& length : line.lengths)
                if (badness(length) > badness(*worst)) worst = &length;
        out.figures = {{"length_mm", "length measurement error E, worst length", worst->error_mm(),
                        worst->expanded_mm, limit_of(*worst)}};
        out.notes = notes();
        for (std::size_t i = 0; i < lines_.size(); ++i) {
            std::vector<JsonResult> lengths;
            for (const BeamLength& length : lines_[i].lengths)
                lengths.push_back(JsonResult()
                                      .set("from", length.from)
                                      .set("to", length.to)
                                      .set("calibrated_mm", length.calibrated_mm)
                                      .set("measured_mm", length.measured_mm)
                                      .set("error_mm", length.error_mm())
                                      .set("expanded_uncertainty_mm", length.expanded_mm));
            for (const MeasuredSphere& sphere : lines_[i].beam.free) {
                out.points_used += sphere.form.points_used;
                out.rejected += sphere.form.rejected;
            }
            out.positions.push_back(JsonResult().set("file", names_[i]).set("lengths", lengths));
        }
        out.sections = sections();
        return out;
    }

    std::vector<std::string> notes() const {
        std::vector<std::string> notes = common_notes(states_, artefact_);
        if (lines_.size() < kLinesAsked || lines_.front().lengths.size() < kLengthsAsked)
            notes.push_back(falls_short("5 lengths on each of 7 lines",
                                        "these are " +
                                            std::to_string(lines_.front().lengths.size()) + " on " +
                                            std::to_string(lines_.size())));
        notes.push_back(kIndependentNote);
        return notes;
    }

    std::vector<ReportSection> sections() const {
        ReportTable table{
            "Lengths over both spheres: distance of the centres and half of either diameter, all "
            "as scanned with free radii, at most 3 of 1000 points rejected.",
            {"scan", "spheres", "measured (mm)", "calibrated (mm)", "E (um)", "U (um)",
             "permitted (um)"},
            {}};
        LinePlot plot;
        plot.x = {.label = "length", .unit = "mm"};
        plot.y = {.label = "E", .unit = "um", .with_zero = true};
        std::vector<const FormFigures*> forms;
        std::vector<std::string> spheres;
        std::vector<Eigen::Vector3d> places;
        PlotSeries dots{"measured", {}, {}, true};
        for (std::size_t i = 0; i < lines_.size(); ++i) {
            for (const BeamLength& length : lines_[i].lengths) {
                const auto limit = limit_of(length);
                table.rows.push_back(
                    {names_[i],
                     std::to_string(length.from + 1) + " to " + std::to_string(length.to + 1),
                     mm_text(length.measured_mm), mm_text(length.calibrated_mm),
                     um(length.error_mm()), um(length.expanded_mm), limit ? um(*limit) : "-"});
                dots.x.push_back(length.calibrated_mm);
                dots.y.push_back(1000 * length.error_mm());
            }
            for (std::size_t k = 0; k < lines_[i].beam.free.size(); ++k) {
                const MeasuredSphere& sphere = lines_[i].beam.free[k];
                spheres.push_back(names_[i] + ", sphere " + std::to_string(k + 1));
                forms.push_back(&sphere.form);
                places.push_back(sphere.centre);
            }
        }
        plot.series = {std::move(dots)};
        if (artefact_.mpe_length_mm) plot.series.push_back(permitted(plot.series[0].x));
        return {
            {"Lengths", {table, ReportDrawing{"Error over length", line_plot_svg(plot)}}},
            {"Residuals on the spheres", {noise_table(spheres, forms), residual_histogram(forms)}},
            {"Where in the volume", places_in_volume(places)}};
    }

    IncidenceOption incidence_;
    SphereRegionOptions options_;
    std::vector<Line> lines_;
};

}  // namespace

std::unique_ptr<Verb> make_verify_length_verb() { return std::make_unique<VerifyLengthVerb>(); }

}  // namespace stria
