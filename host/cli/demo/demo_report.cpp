#include "host/cli/demo/demo_report.h"

#include <cmath>
#include <numbers>

#include "host/render/cluster.h"
#include "host/render/mesh_picture.h"
#include "host/render/plot.h"
#include "host/render/range_picture.h"
#include "host/report/report.h"

namespace stria {
namespace {

using Eigen::Vector3d;

std::string num(double value, int digits = 3) { return format_number(value, digits); }

ReportFigure figure(const std::string& name, double value, const std::string& unit, double limit) {
    return {name, num(value), unit, "<= " + num(limit), value <= limit};
}

std::vector<ReportFigure> summary(const DemoResult& r) {
    std::vector<ReportFigure> lines;
    lines.push_back(
        figure("mesh error, smooth parts, rms", r.truth.smooth.rms_mm, "mm", 0.1 * r.voxel_mm));
    lines.push_back(figure("mesh error, all that was seen, rms", r.truth.all.rms_mm, "mm",
                           0.05 / 0.3 * r.voxel_mm));
    lines.push_back(figure("mesh error, 99 % of points below", r.truth.all.p99_mm, "mm",
                           0.2 / 0.3 * r.voxel_mm));
    lines.push_back({"actual over predicted sigma of a point", num(r.sigma_ratio), "",
                     "0.8 to 1.25", r.sigma_ratio >= 0.8 && r.sigma_ratio <= 1.25});
    lines.push_back({"predicted sigma of a point, median", num(r.median_sigma_mm), "mm", "", {}});
    lines.push_back({"calibration, corners, rms", num(r.calibration_rms_px), "px", "", {}});
    lines.push_back(figure("calibration, points after the best rigid motion, rms over diagonal",
                           r.calibration_point_rms_mm / r.calibration_diagonal_mm, "", 1e-4));
    lines.push_back({"time", num(r.clock.total_seconds()), "s", "", {}});
    return lines;
}

ReportSection stripe_section(const DemoResult& r) {
    ReportPictures pictures;
    for (const Frame& frame : r.stripe_frames)
        pictures.pictures.push_back({"one frame, brightened", picture_of_frame(frame, 2.0, 480)});
    return {
        "What the camera saw",
        {ReportText{"Frames of one sweep: the stripe crosses the object, whose paint is 5:1 light "
                    "to dark. Every pixel's rise and fall in time is fitted as the stripe passes."},
         pictures}};
}

ReportSection range_section(const DemoResult& r) {
    ReportPictures pictures;
    ReportTable table{"The scans, each against the truth after its own best rigid motion",
                      {"scan", "points", "predicted sigma (mm)", "median |error| (mm)",
                       "actual / predicted", "pose error (deg)", "pose error (mm)"},
                      {}};
    for (std::size_t i = 0; i < r.scans.size(); ++i) {
        pictures.pictures.push_back(
            {"scan " + std::to_string(i + 1), picture_of_range(r.scans[i], 300).picture});
        const SigmaTruth& sigma = r.sigma[i];
        table.rows.push_back(
            {std::to_string(i + 1), std::to_string(valid_count(r.scans[i])),
             num(sigma.median_sigma_mm), num(sigma.median_error_mm), num(sigma.sigma_ratio),
             num(r.pose_error_rad[i] * 180 / std::numbers::pi, 2), num(r.pose_error_mm[i], 2)});
    }
    return {"Range images", {pictures, table}};
}

ReportSection sigma_section(const DemoResult& r) {
    Histogram histogram;
    histogram.x = {"error over predicted sigma", "", false};
    for (const SigmaTruth& sigma : r.sigma)
        histogram.values.insert(histogram.values.end(), sigma.normalised.begin(),
                                sigma.normalised.end());
    histogram.low = -5;
    histogram.high = 5;
    histogram.normal_sigma = 1;
    histogram.normal_name = "honest sigma";
    return {"Is the sigma honest?",
            {ReportText{"Each point's error along the direction it errs in, over the standard "
                        "deviation that it carries; points farther than 3 pixels from edges."},
             ReportDrawing{"Predicted against actual", histogram_svg(histogram)}}};
}

ReportSection registration_section(const DemoResult& r) {
    LinePlot plot;
    plot.x = {"step", "", false};
    plot.y = {"distance", "mm", true};
    PlotSeries rms{"rms of the overlap", {}, {}, false}, moved{"largest move", {}, {}, false};
    for (std::size_t i = 0; i < r.convergence.rms_mm.size(); ++i) {
        const auto step = static_cast<double>(i + 1);
        rms.x.push_back(step);
        rms.y.push_back(r.convergence.rms_mm[i]);
        moved.x.push_back(step);
        moved.y.push_back(r.convergence.move_mm[i]);
    }
    plot.series = {rms, moved};
    return {"Registration",
            {ReportText{"The scans came without poses. A coarse start places them, then all are "
                        "moved jointly until their overlaps agree to " +
                        num(r.overlap_rms_mm) + " mm rms."},
             ReportDrawing{"Joint registration, coarse to fine", line_plot_svg(plot)}}};
}

std::vector<std::string> error_row(const std::string& name, const ErrorFigures& f) {
    return {name,          std::to_string(f.count), num(f.mean_mm), num(f.rms_mm),
            num(f.p95_mm), num(f.p99_mm),           num(f.max_mm)};
}

ReportSection mesh_section(const DemoResult& r) {
    const auto& errors = r.open_mesh.find_attribute("error")->values;
    const ColourScale scale = positive_scale(errors, 0.98, "distance to the truth", "mm");
    // The pictures show the object upright whatever the first scan's frame was.
    const Eigen::Matrix3d world_from_object = r.truth.object_from_world.rotation.transpose();
    MeshPictureOptions view;
    view.up = world_from_object * Vector3d::UnitY();
    view.width = 460;
    view.height = 460;
    ReportPictures pictures;
    pictures.scale = scale;
    const auto open_colours = vertex_colours(r.open_mesh, "error", scale);
    const auto filled_colours = vertex_colours(r.filled_mesh, "error", scale);
    for (const Vector3d& eye : {Vector3d(0.3, 0.35, 1), Vector3d(-0.9, 0.3, -0.4)}) {
        view.towards_eye = world_from_object * eye;
        pictures.pictures.push_back(
            {"measured parts only", picture_of_mesh(r.open_mesh, open_colours, view)});
        pictures.pictures.push_back(
            {"holes filled", picture_of_mesh(r.filled_mesh, filled_colours, view)});
    }
    ReportTable table{"Distances after one best rigid motion of the whole mesh, mm",
                      {"what", "points", "mean", "rms", "95 %", "99 %", "max"},
                      {error_row("smooth parts, both directions", r.truth.smooth),
                       error_row("all seen under 70 deg, both directions", r.truth.all),
                       error_row("mesh to truth", r.truth.mesh_to_truth),
                       error_row("truth to mesh", r.truth.truth_to_mesh),
                       error_row("filled parts, apart", r.filled)}};
    return {"The mesh", {pictures, table}};
}

/// Every n-th cell's cluster as one vertex, small enough for a page.
ReportSection viewer_section(const DemoResult& r) {
    const ColourScale scale = positive_scale(r.open_mesh.find_attribute("error")->values, 0.98,
                                             "distance to the truth", "mm");
    ReportMesh mesh;
    mesh.mesh = clustered(r.filled_mesh, 1.2);
    mesh.colours = vertex_colours(mesh.mesh, "error", scale);
    mesh.scale = scale;
    const Eigen::Matrix3d world_from_object = r.truth.object_from_world.rotation.transpose();
    mesh.up = world_from_object * Vector3d::UnitY();
    mesh.towards_eye = world_from_object * Vector3d(0.3, 0.35, 1);
    return {"Look at it", {mesh}};
}

ReportSection cost_section(const DemoResult& r) {
    ReportTable table{"", {"stage", "time (s)", "CPU (s)", "peak memory (MB)"}, {}};
    for (const StageCost& stage : r.clock.stages())
        table.rows.push_back(
            {stage.name, num(stage.seconds), num(stage.cpu_seconds), num(stage.peak_rss_mb)});
    return {"Time and memory", {table}};
}

}  // namespace

void write_demo_report(const std::string& path, const DemoResult& result, unsigned seed) {
    Report report;
    report.title = "stria demo: from nothing to a measured mesh";
    report.subtitle = "Simulated swept-stripe scanner, seed " + std::to_string(seed) + ", voxel " +
                      num(result.voxel_mm) + " mm, calibrated on a board before the scans";
    report.summary = summary(result);
    report.sections = {mesh_section(result),  viewer_section(result), stripe_section(result),
                       range_section(result), sigma_section(result),  registration_section(result),
                       cost_section(result)};
    write_report(path, report);
}

}  // namespace stria
