#include "host/cli/verify_pictures.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "host/cli/verify_run.h"
#include "host/render/plot.h"
#include "host/render/range_picture.h"

namespace stria {
namespace {

constexpr int kSide = 240;  // px, of a map

/// The cells of a grid blown up to whole squares of pixels.
ColourImage enlarged(const ColourImage& small, int factor) {
    ColourImage large(small.width * factor, small.height * factor, 3);
    for (int y = 0; y < large.height; ++y)
        for (int x = 0; x < large.width; ++x)
            for (int c = 0; c < 3; ++c) large.at(x, y, c) = small.at(x / factor, y / factor, c);
    return large;
}

/// Lines in a plot of micrometres from x to x: at plus and where `both` at minus that many mm.
PlotSeries permitted_lines(double from, double to, double mpe_mm, bool both) {
    const double um = 1000 * mpe_mm;
    PlotSeries lines{"permitted", {from, to}, {um, um}};
    if (both) {
        const double parted = std::numeric_limits<double>::quiet_NaN();
        lines.x.insert(lines.x.end(), {to, from, to});
        lines.y.insert(lines.y.end(), {parted, -um, -um});
    }
    return lines;
}

}  // namespace

ColourImage scattered_picture(const std::vector<Eigen::Vector2d>& places,
                              const std::vector<float>& values, const ColourScale& scale,
                              double height) {
    // Three points a cell or more, so that few cells of the surface stay empty; whole pixels a
    // cell.
    const int wanted = std::clamp(
        static_cast<int>(std::sqrt(static_cast<double>(places.size()) / (3 * height))), 8, kSide);
    const int enlargement = (kSide + wanted - 1) / wanted;
    const int columns = kSide / enlargement;
    const int rows = std::max(1, static_cast<int>(std::lround(height * columns)));
    const auto count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    std::vector<float> sums(count, 0.0F);
    std::vector<int> counts(count, 0);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const int x = std::clamp(static_cast<int>(places[i].x() * columns), 0, columns - 1);
        const int y = std::clamp(static_cast<int>(places[i].y() / height * rows), 0, rows - 1);
        const auto cell = static_cast<std::size_t>(y * columns + x);
        sums[cell] += values[i];
        ++counts[cell];
    }
    std::vector<std::uint8_t> mask(count, 0);
    for (std::size_t i = 0; i < count; ++i) {
        if (counts[i] == 0) continue;
        mask[i] = 1;
        sums[i] /= static_cast<float>(counts[i]);
    }
    return enlarged(picture_of_values(columns, rows, sums, mask, scale, kSide), enlargement);
}

ColourImage residual_map(const MeasuredSphere& sphere, const ColourScale& scale) {
    const Eigen::Vector3d& middle = sphere.middle;
    const Eigen::Vector3d up =
        std::abs(middle.y()) < 0.9 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d right = up.cross(middle).normalized();
    const Eigen::Vector3d above = middle.cross(right);
    std::vector<Eigen::Vector2d> places;
    std::vector<float> values;
    for (std::size_t i = 0; i < sphere.points.positions.size(); ++i) {
        const Eigen::Vector3d n = (sphere.points.positions[i] - sphere.centre).normalized();
        const Eigen::Vector2d across(n.dot(right), -n.dot(above));
        const double angle = std::atan2(across.norm(), n.dot(middle));
        const double stretch = angle / (2 * sphere.cap_rad * std::max(across.norm(), 1e-12));
        places.emplace_back(Eigen::Vector2d::Constant(0.5) + stretch * across);
        values.push_back(static_cast<float>(1000 * sphere.form.residuals_mm[i]));
    }
    return scattered_picture(places, values, scale);
}

void add_residuals(const FormFigures& form, std::vector<float>& residuals_um) {
    for (const double r : form.residuals_mm) residuals_um.push_back(static_cast<float>(1000 * r));
}

ColourScale residual_scale(const std::vector<float>& residuals_um) {
    // A cell shows the mean of some points, which scatters less than one: no wider than 90 %.
    return symmetric_scale(residuals_um, 0.9, "residual, outside positive", "um");
}

ReportDrawing residual_histogram(const std::vector<const FormFigures*>& forms) {
    const bool predicted = std::all_of(forms.begin(), forms.end(), [](const FormFigures* f) {
        return std::isfinite(f->predicted_sigma_mm);
    });
    Histogram histogram;
    histogram.x = {predicted ? "residual over the predicted standard deviation"
                             : "residual over the measured standard deviation",
                   "", false};
    for (const FormFigures* form : forms)
        for (std::size_t i = 0; i < form->residuals_mm.size(); ++i)
            histogram.values.push_back(form->residuals_mm[i] /
                                       (predicted ? form->point_sigmas_mm[i] : form->sigma_mm));
    histogram.low = -6;
    histogram.high = 6;
    histogram.normal_sigma = 1;
    histogram.normal_name = predicted ? "as predicted" : "normal";
    return {"All measured points of all positions, rejected ones too", histogram_svg(histogram)};
}

ReportDrawing by_position(const std::string& caption, const std::string& label,
                          const std::vector<double>& measured_mm,
                          const std::vector<double>& expected_mm, std::optional<double> mpe_mm) {
    LinePlot plot;
    plot.x = {.label = "position", .unit = "", .whole = true};
    plot.y = {.label = label, .unit = "um", .with_zero = true};
    PlotSeries measured{"measured", {}, {}, true}, expected{"from noise alone", {}, {}, true};
    for (std::size_t i = 0; i < measured_mm.size(); ++i) {
        measured.x.push_back(static_cast<double>(i + 1));
        measured.y.push_back(1000 * measured_mm[i]);
        if (i >= expected_mm.size() || !std::isfinite(expected_mm[i])) continue;
        expected.x.push_back(static_cast<double>(i + 1));
        expected.y.push_back(1000 * expected_mm[i]);
    }
    plot.series = {measured};
    if (!expected.x.empty()) plot.series.push_back(expected);
    const bool both =
        std::any_of(measured_mm.begin(), measured_mm.end(), [](double value) { return value < 0; });
    const double last = static_cast<double>(measured_mm.size()) + 0.5;
    if (mpe_mm) plot.series.push_back(permitted_lines(0.5, last, *mpe_mm, both));
    return {caption, line_plot_svg(plot)};
}

ReportTable noise_table(const std::vector<std::string>& names,
                        const std::vector<const FormFigures*>& forms) {
    ReportTable table{
        "Noise: standard deviation about the fit. Predicted: from the points' own sigmas, rms; "
        "their ratio is robust (MAD), point by point. Systematic: what calibration shares, most "
        "of which a fit takes away.",
        {"scan", "noise (um)", "predicted (um)", "measured / predicted", "form / predicted",
         "systematic (um)"},
        {}};
    for (std::size_t i = 0; i < forms.size(); ++i) {
        const FormFigures& f = *forms[i];
        table.rows.push_back({names[i], um(f.sigma_mm), um(f.predicted_sigma_mm),
                              format_number(f.sigma_ratio), format_number(f.form_ratio),
                              um(f.predicted_systematic_mm)});
    }
    return table;
}

std::vector<ReportBlock> places_in_volume(const std::vector<Eigen::Vector3d>& places) {
    std::vector<ReportBlock> drawings;
    for (const int axis : {1, 2}) {
        LinePlot plot;
        plot.x = {"x in the scan", "mm", false};
        plot.y = {axis == 1 ? "y in the scan" : "z in the scan", "mm", false};
        PlotSeries dots{"", {}, {}, true};
        for (const Eigen::Vector3d& p : places) {
            dots.x.push_back(p.x());
            dots.y.push_back(p[axis]);
        }
        plot.series = {dots};
        drawings.push_back(ReportDrawing{
            axis == 1 ? "Where the artefact stood, x and y" : "Where the artefact stood, x and z",
            line_plot_svg(plot)});
    }
    return drawings;
}

}  // namespace stria
