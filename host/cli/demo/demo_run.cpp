#include "host/cli/demo/demo_run.h"

#include <cmath>
#include <filesystem>
#include <mutex>

#include "calib/scanner_calibration.h"
#include "firmware/core/median.h"
#include "host/cli/calibration_views.h"
#include "host/cli/demo/demo_capture.h"
#include "host/cli/demo/demo_scene.h"
#include "host/cli/fast_analysis.h"
#include "host/cli/progress.h"
#include "host/cli/recording_range.h"
#include "host/core/errors.h"
#include "host/fusion/fuse.h"
#include "host/geometry/align.h"
#include "host/geometry/parallel.h"
#include "host/io/mesh_io.h"
#include "host/io/model_io.h"
#include "host/io/range_io.h"
#include "host/local/open_device.h"
#include "host/project/project.h"
#include "host/registration/coarse.h"
#include "host/registration/joint.h"
#include "sim/simulated_scanner.h"

namespace stria {
namespace {

using Eigen::Vector3d;

/// The folders of a run.
struct Folders {
    explicit Folders(const std::string& root)
        : scenes(root + "/scenes"), boards(root + "/calibration"), part(root + "/part") {
        std::filesystem::remove_all(root);  // --force was given, or nothing is there
        for (const std::string& folder : {scenes, boards})
            std::filesystem::create_directories(folder);
        create_project(part, "sculpture");
    }
    std::string scenes, boards, part;
};

std::unique_ptr<DeviceClient> open_scene(const std::string& scene, const Context& context) {
    OpenOptions options;
    options.seed = context.seed;
    return open_device("sim:" + scene, options);
}

std::vector<std::string> capture(const Context& context, const std::string& scene,
                                 const char* title, const ScanPlan& plan, bool fast, int views,
                                 const std::string& folder) {
    std::unique_ptr<Progress> progress;
    const auto open = [&] {
        auto device = open_scene(scene, context);
        if (fast) ask_for_fast_analysis(*device, plan);
        return device;
    };
    return capture_views(open, plan, views, folder, [&](std::size_t done, std::size_t total) {
        if (!progress) progress = std::make_unique<Progress>(context, title, total, "frames");
        progress->update(done);
    });
}

ScannerModel calibrate(const std::vector<std::string>& recordings, const DemoSetup& setup,
                       DemoResult& result) {
    std::vector<CalibrationView> views(recordings.size());
    ScannerModel nominal;
    parallel_for_blocks(recordings.size(), 1, [&](std::size_t i, std::size_t) {
        const RecordingContents contents = load_recording(recordings[i]);
        if (i == 0) nominal = nominal_model_of(contents, recordings[i]);
        views[i] = calibration_view_of(contents, recordings[i]);
    });
    const ScannerCalibration calibration = calibrate_scanner(views, setup.board, nominal);
    if (!calibration.converged)
        throw Error("the calibration did not converge; see its warnings: " +
                    (calibration.warnings.empty() ? "none" : calibration.warnings.front()));
    result.calibration_rms_px = calibration.rms_px;
    result.calibration_warnings = calibration.warnings;
    return calibration.model;
}

/// Calibrated against true model: rms of the points that both place into the same pixels and s,
/// over the field and the sweep, after the best rigid motion.
void judge_calibration(const ScannerModel& model, const ScannerModel& truth, const ScanPlan& plan,
                       DemoResult& result) {
    std::vector<Vector3d> ours, true_ones;
    const Channel &a = model.channels.front(), &b = truth.channels.front();
    for (int v = 20; v < a.camera.height; v += 40)
        for (int u = 20; u < a.camera.width; u += 40)
            for (int k = 0; k <= 20; ++k) {
                const double s = plan.from + (plan.to - plan.from) * k / 20;
                const auto p = triangulate(a, Eigen::Vector2d(u, v), s);
                const auto q = triangulate(b, Eigen::Vector2d(u, v), s);
                if (!p || !q || q->point_in_scan.z() > -380 || q->point_in_scan.z() < -540)
                    continue;
                ours.push_back(p->point_in_scan);
                true_ones.push_back(q->point_in_scan);
            }
    const Rigid3 motion = align_points(ours, true_ones);
    double squares = 0;
    Vector3d low = Vector3d::Constant(1e300), high = -low;
    for (std::size_t i = 0; i < ours.size(); ++i) {
        squares += (motion * ours[i] - true_ones[i]).squaredNorm();
        low = low.cwiseMin(true_ones[i]);
        high = high.cwiseMax(true_ones[i]);
    }
    result.calibration_point_rms_mm = std::sqrt(squares / static_cast<double>(ours.size()));
    result.calibration_diagonal_mm = (high - low).norm();
}

void make_ranges(const std::vector<std::string>& recordings, const ScannerModel& model,
                 const Context& context, DemoResult& result) {
    Progress progress(context, "range images", recordings.size(), "scans");
    std::vector<std::string> lines(recordings.size());
    result.scans.resize(recordings.size());
    std::mutex done_mutex;
    std::size_t done = 0;
    parallel_for_blocks(recordings.size(), 1, [&](std::size_t i, std::size_t) {
        RangeResult range = range_of(load_recording(recordings[i]), model, recordings[i]);
        const auto out = std::filesystem::path(recordings[i]).parent_path() / "range.ply";
        write_range_image(out.string(), range.image);
        lines[i] = out.string() + ": " + describe(range.statistics);
        result.scans[i] = std::move(range.image);
        const std::lock_guard lock(done_mutex);
        progress.update(++done);
    });
    for (const std::string& line : lines) context.say(line);
}

/// Poses from the scans' shapes alone: nobody says where the object lay.
void register_scans(const std::vector<std::string>& recordings, const std::string& part,
                    DemoResult& result) {
    std::vector<ScanSurface> surfaces;
    for (const RangeImage& image : result.scans) surfaces.push_back(prepare_surface(image));
    const CoarseResult coarse = place_scans(surfaces);
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        if (!coarse.scans[i].placed)
            throw Error("scan " + std::to_string(i + 1) +
                        " could not be placed: " + coarse.scans[i].reason);
        ScanPose pose;
        pose.file = relative_name(std::filesystem::path(recordings[i]).parent_path() / "range.ply",
                                  part + "/poses.toml");
        pose.world_from_scan = coarse.scans[i].world_from_scan;
        result.poses.push_back(std::move(pose));
    }
    const JointResult joint = register_jointly(surfaces, result.poses);
    if (!joint.converged) throw Error("registration did not converge: " + joint.reason);
    for (std::size_t i = 0; i < result.poses.size(); ++i) {
        result.poses[i].world_from_scan = joint.scans[i].world_from_scan;
        result.poses[i].covariance = joint.scans[i].covariance;
    }
    result.overlap_rms_mm = joint.overlap_rms_mm;
    for (const JointStep& step : joint.history) {
        result.convergence.rms_mm.push_back(step.rms_mm);
        result.convergence.move_mm.push_back(step.largest_move_mm);
    }
    write_poses(part + "/poses.toml", result.poses);
}

void fuse_scans(const DemoSetup& setup, const std::string& part, const Context& context,
                DemoResult& result) {
    std::vector<FuseScan> scans;
    for (std::size_t i = 0; i < result.scans.size(); ++i)
        scans.push_back({&result.scans[i], result.poses[i].world_from_scan});
    FuseOptions options;
    options.voxel_mm = setup.voxel_mm;
    FusedVolume fused = fuse_volume(scans, options);
    result.voxel_mm = setup.voxel_mm;
    result.open_mesh = fused_surface(fused, options);
    options.fill_holes = true;
    result.filled_mesh = fused_surface(fused, options);
    write_mesh(part + "/model-open.ply", result.open_mesh);
    write_mesh(part + "/model.ply", result.filled_mesh);
    write_mesh(part + "/model.glb", result.filled_mesh);
    context.say("mesh: " + std::to_string(result.filled_mesh.triangles.size()) + " triangles, " +
                part + "/model.ply");
}

/// What the simulator knows and the processing above did not: for comparison only.
struct Truth {
    SculptureTruth sculpture{make_sculpture()};
    ScannerModel scanner;
    std::vector<Rigid3> object_from_scan;
    std::vector<TrueView> views;
};

void read_truth(const std::string& scene_file, const ScanPlan& plan, Truth& truth) {
    const Scene scene = read_scene(scene_file);
    const Channel& channel = scene.channel;
    truth.scanner.channels.push_back(channel);
    const Rigid3 scan_from_cam = scan_from_camera(channel, 0);
    const double middle = 0.5 * (plan.from + plan.to);
    for (const SceneView& view : scene.views) {
        const Rigid3 object_from_scan = view.poses.front().world_from_object.inverse();
        truth.object_from_scan.push_back(object_from_scan);
        TrueView seen;
        seen.camera = object_from_scan * scan_from_cam.translation;
        seen.laser = object_from_scan * (scan_from_cam * sheet_at(channel, middle).apex);
        seen.camera_from_object = (object_from_scan * scan_from_cam).inverse();
        seen.half_field_x = 0.5 * channel.camera.width / channel.camera.fx;
        seen.half_field_y = 0.5 * channel.camera.height / channel.camera.fy;
        truth.views.push_back(seen);
    }
}

/// Errors of the registered poses against each scan's own best place on the truth, after the motion
/// that all have in common is taken out.
void judge_poses(DemoResult& result) {
    const std::vector<Vector3d> marks = {{60, 0, 0},  {-60, 0, 0}, {0, 60, 0},
                                         {0, -60, 0}, {0, 0, 60},  {0, 0, -60}};
    std::vector<Vector3d> ours, true_ones;
    for (std::size_t i = 0; i < result.poses.size(); ++i)
        for (const Vector3d& mark : marks) {
            const Rigid3 scan_from_object = result.sigma[i].object_from_scan.inverse();
            ours.push_back(result.poses[i].world_from_scan * (scan_from_object * mark));
            true_ones.push_back(mark);
        }
    const Rigid3 object_from_world = align_points(ours, true_ones);
    for (std::size_t i = 0; i < result.poses.size(); ++i) {
        const Rigid3 error = object_from_world * result.poses[i].world_from_scan *
                             result.sigma[i].object_from_scan.inverse();
        result.pose_error_rad.push_back(vector_from_rotation(error.rotation).norm());
        result.pose_error_mm.push_back(error.translation.norm());
    }
}

void compare(const Truth& truth, const Context& context, DemoResult& result) {
    Progress progress(context, "comparing with the truth", result.scans.size() + 2, "steps");
    std::size_t done = 0;
    std::vector<double> ratios, sigmas;
    for (std::size_t i = 0; i < result.scans.size(); ++i) {
        result.sigma.push_back(
            sigma_against_truth(result.scans[i], truth.sculpture, truth.object_from_scan[i]));
        ratios.push_back(result.sigma.back().sigma_ratio);
        sigmas.push_back(result.sigma.back().median_sigma_mm);
        progress.update(++done);
    }
    result.sigma_ratio = median(ratios);
    result.median_sigma_mm = median(sigmas);
    judge_poses(result);
    const Rigid3 object_from_world =
        truth.object_from_scan.front() * result.poses.front().world_from_scan.inverse();
    result.truth = compare_with_truth(result.open_mesh, truth.sculpture, truth.views,
                                      object_from_world, context.seed);
    progress.update(++done);
    result.open_mesh.attributes.push_back({"error", 1, result.truth.vertex_error_mm});
    FilledTruth filled = compare_filled_with_truth(result.filled_mesh, truth.sculpture,
                                                   result.truth.object_from_world);
    result.filled = filled.filled;
    result.filled_mesh.attributes.push_back({"error", 1, std::move(filled.vertex_error_mm)});
}

}  // namespace

DemoResult run_demo(const Context& context, const DemoOptions& options) {
    DemoResult result;
    StageClock& clock = result.clock;
    const DemoSetup setup = make_demo_setup(options.quick);
    const Folders folders(options.folder);

    clock.begin("scenes");
    write_demo_scenes(setup, folders.scenes, context.seed, options.quick);

    clock.begin("board sweeps");
    const auto boards = capture(context, folders.scenes + "/board.toml", "sweeping over the board",
                                setup.board_plan, options.fast, setup.board_views, folders.boards);
    clock.begin("calibration");
    const ScannerModel model = calibrate(boards, setup, result);
    write_scanner(folders.part + "/scanner.toml", model);

    clock.begin("object sweeps");
    const std::string object = folders.scenes + "/object.toml";
    const auto scans = capture(context, object, "scanning the object", setup.object_plan,
                               options.fast, setup.object_views, folders.part + "/scans");
    result.stripe_frames = sample_stripe_frames(*open_scene(object, context), setup.object_plan, 3);

    clock.begin("range images");
    make_ranges(scans, model, context, result);

    clock.begin("registration");
    register_scans(scans, folders.part, result);

    clock.begin("fusion");
    fuse_scans(setup, folders.part, context, result);

    clock.begin("comparison with the truth");
    Truth truth;
    read_truth(folders.scenes + "/object.toml", setup.object_plan, truth);
    judge_calibration(model, truth.scanner, setup.object_plan, result);
    compare(truth, context, result);
    clock.end();
    return result;
}

}  // namespace stria
