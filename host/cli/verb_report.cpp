#include <algorithm>
#include <filesystem>

#include "firmware/core/median.h"
#include "host/cli/verbs.h"
#include "host/cli/version.h"
#include "host/core/errors.h"
#include "host/io/mesh_io.h"
#include "host/io/model_io.h"
#include "host/io/range_io.h"
#include "host/mesh/mesh_info.h"
#include "host/project/project.h"
#include "host/render/cluster.h"
#include "host/render/mesh_picture.h"
#include "host/render/range_picture.h"
#include "host/report/report.h"

namespace stria {
namespace {

namespace fs = std::filesystem;

std::string num(double value) { return format_number(value); }

ReportSection scans_section(const Project& project, std::size_t& scans_shown) {
    ReportPictures pictures;
    ReportTable table{
        "",
        {"scan", "kind", "grid", "points", "median sigma (mm)", "median systematic sigma (mm)"},
        {}};
    for (const ScanFolder& scan : list_scans(project)) {
        if (!fs::exists(scan.range())) {
            table.rows.push_back({scan.name, "no range image yet", "", "", "", ""});
            continue;
        }
        const RangeImage image = read_range_image(scan.range());
        std::vector<double> random, systematic;
        for (std::size_t i = 0; i < image.cell_count(); ++i)
            if (image.mask[i]) {
                random.push_back(image.points[i].sigma_mm);
                systematic.push_back(image.points[i].sigma_systematic_mm);
            }
        table.rows.push_back({scan.name, name_of(image.kind),
                              std::to_string(image.width) + " x " + std::to_string(image.height),
                              std::to_string(random.size()), num(median(random)),
                              num(median(systematic))});
        pictures.pictures.push_back({"scan " + scan.name, picture_of_range(image, 300).picture});
        ++scans_shown;
    }
    return {"Scans", {pictures, table}};
}

ReportSection poses_section(const Project& project) {
    ReportTable table{"world from scan", {"scan", "x (mm)", "y (mm)", "z (mm)", "turn (deg)"}, {}};
    for (const ScanPose& pose : read_poses(project.poses())) {
        const Eigen::Vector3d& t = pose.world_from_scan.translation;
        const double turn =
            vector_from_rotation(pose.world_from_scan.rotation).norm() * 57.29577951308232;
        table.rows.push_back({pose.file, num(t.x()), num(t.y()), num(t.z()), num(turn)});
    }
    return {"Poses", {table}};
}

ReportSection mesh_section(const std::string& path) {
    const TriMesh mesh = read_mesh(path);
    const MeshInfo info = mesh_info(mesh);
    ReportTable table{"",
                      {"vertices", "triangles", "components", "boundary edges",
                       "non-manifold edges", "area (mm2)", "volume (mm3)", "closed"},
                      {{std::to_string(info.vertices), std::to_string(info.triangles),
                        std::to_string(info.components), std::to_string(info.boundary_edges),
                        std::to_string(info.non_manifold_edges), num(info.area_mm2),
                        num(info.volume_mm3), info.closed ? "yes" : "no"}}};
    ReportPictures pictures;
    MeshPictureOptions view;
    for (const Eigen::Vector3d& eye :
         {Eigen::Vector3d(0.4, 0.3, 1), Eigen::Vector3d(-0.8, 0.3, -0.6)}) {
        view.towards_eye = eye;
        view.up = Eigen::Vector3d::UnitY();
        pictures.pictures.push_back(
            {fs::path(path).filename().string(), picture_of_mesh(mesh, {}, view)});
    }
    Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
    for (const auto& p : mesh.positions) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    ReportMesh viewer;
    const double size = mesh.positions.empty() ? 1.0 : (high - low).norm();
    viewer.mesh = clustered(mesh, std::max(1e-6, size / 150));
    viewer.up = Eigen::Vector3d::UnitY();
    viewer.towards_eye = {0.4, 0.3, 1};
    return {"Mesh", {pictures, table, viewer}};
}

class ReportVerb final : public Verb {
  public:
    std::string name() const override { return "report"; }
    std::string summary() const override { return "a project's page: scans, poses, mesh"; }
    void declare(Arguments& arguments) override {
        arguments.positional("PROJECT", folder_, "project folder");
        arguments.option("--out", out_, "page to write; without it report.html in the project");
    }

    int run(const Context& context) override {
        const Project project = open_project(folder_);
        const std::string out = out_.empty() ? project.report() : out_;
        context.check_output(out);
        Report report;
        report.title = project.name;
        report.subtitle = "stria " + std::string(kVersion);
        std::size_t scans = 0;
        report.sections.push_back(scans_section(project, scans));
        if (fs::exists(project.poses())) report.sections.push_back(poses_section(project));
        if (fs::exists(project.model_ply()))
            report.sections.push_back(mesh_section(project.model_ply()));
        if (fs::exists(project.scanner())) {
            const ScannerModel model = read_scanner(project.scanner());
            report.summary.push_back(
                {"calibration, rms", num(model.provenance.rms_px), "px", "", {}});
        }
        report.summary.push_back({"scans", std::to_string(scans), "", "", {}});
        write_report(out, report);
        context.say("report: " + out);
        context.finish(JsonResult().set("report", out).set("scans", scans));
        return 0;
    }

  private:
    std::string folder_, out_;
};

}  // namespace

std::unique_ptr<Verb> make_report_verb() { return std::make_unique<ReportVerb>(); }

}  // namespace stria
