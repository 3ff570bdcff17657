#include "tests/host/cli/edge_cards.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "firmware/stripe/path_spacetime.h"
#include "firmware/stripe/spatial.h"
#include "host/local/local_scanner.h"
#include "host/scan/path_table.h"
#include "tests/host/cli/rotated_spacetime.h"
#include "tests/support/machine_scenes.h"

namespace stria::test_support {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBeamMm = 0.5;
constexpr double kEdgesMm = 5;  // from edge to edge
constexpr double kMarginMm = 4 * kBeamMm;
constexpr double kRowsMm = 0.9;  // three rows: light between rows is of four of them

/// A card of that size with edges parallel to its y axis.
SceneObject card(const std::string& name, const Rigid3& pose, const Vector2d& size) {
    SceneObject object;
    object.name = name;
    object.shape = SceneShape::plane;
    object.size_mm = size;
    object.corner_mm = -size / 2;
    object.albedo = 0.8;
    object.world_from_object = pose;
    GreyImage stripes;
    stripes.width = 400;
    stripes.height = 1;
    for (int x = 0; x < stripes.width; ++x)
        stripes.values.push_back(x < stripes.width / 2 ? 250 : 25);
    object.texture = "stripes.png";
    object.texture_size_mm = {2 * kEdgesMm, size.y()};
    object.texture_image = std::make_shared<const GreyImage>(stripes);
    return object;
}

/// Three bands of rows, one above the other, a card in each where the sheet of s = 0 meets its
/// depth; so none hides another from camera or laser.
std::vector<SceneObject> cards_at(const std::array<double, 3>& depths_mm, double width_mm,
                                  const CameraModel& camera, bool table) {
    Eigen::Matrix3d upright;  // a card's face towards the camera at the table's -y
    upright << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    std::vector<SceneObject> cards;
    for (std::size_t i = 0; i < depths_mm.size(); ++i) {
        const double depth = depths_mm[i], band = camera.height / 3.0;
        const double row = (static_cast<double>(i) + 0.5) * band - 0.5;
        const double x = 180 * (1 - depth / 450);
        const double up = -(row - camera.cy) / camera.fy * depth;
        const double height = (band - 3) * depth / camera.fy;  // 3 px between them
        const Rigid3 pose = table ? Rigid3{upright, Vector3d(x, depth - 450, up)}
                                  : Rigid3{Eigen::Matrix3d::Identity(), Vector3d(x, up, -depth)};
        cards.push_back(card("card " + std::to_string(i), pose, {width_mm, height}));
    }
    return cards;
}

const Channel& channel_of(const EdgeCards& cards) { return cards.scene.channel; }

/// Where the middle card's centre is seen as the sheet crosses it.
Vector2d middle_of(const EdgeCards& cards) {
    const Vector3d centre = cards.scene.objects[1].world_from_object.translation;
    const Channel& channel = channel_of(cards);
    return project(channel.camera, scan_from_camera(channel, 0).inverse() * centre).value();
}

/// The table's path in the middle of the field.
ImagePath middle_path(const EdgeCards& cards) {
    const Channel& channel = channel_of(cards);
    const Vector2d middle = middle_of(cards);
    return path_at(make_path_table(channel, ""), middle.x(), middle.y()).value();
}

std::vector<Crossing> pulses_along(const RecordingContents& sweep, const PathTable& table) {
    PathAnalyser analyser(table, sweep.frames.front().bits, sweep.snapshot.device.noise);
    for (const Frame& frame : sweep.frames)
        if (const auto axis = position_at(sweep.axis_log, frame.row_time(0)))
            analyser.add(frame, *axis);
    PulseMap map = analyser.finish();
    assign_axis_positions(map, sweep.axis_log);
    std::vector<Crossing> crossings;
    for (const Pulse& pulse : map.pulses)
        if ((pulse.flags & (kPulseTouchesSequenceEnd | kPulseSpatialFallback)) == 0)
            crossings.push_back({pulse.u, pulse.v, pulse.s});
    return crossings;
}

}  // namespace

EdgeCards edge_cards(MachineKind kind, int rows, double psf_sigma_px) {
    const bool rail = kind == MachineKind::rail;
    EdgeCards made;
    Scene& scene = made.scene = machine_scenes(kind, 3).sphere_scene;
    scene.sensor.noise = false;
    scene.sensor.bits = 12;
    scene.sensor.gain_e_per_dn /= 16;
    scene.ambient_level = 0;
    scene.laser_power_mw *= rail ? 0.35 : 0.4;
    scene.lens.psf_sigma_px = psf_sigma_px;
    scene.channel.sheet.waist_sigma_mm = kBeamMm;
    CameraModel& camera = scene.channel.camera;
    camera.cy += 0.5 * (rows - camera.height);
    camera.height = rows;
    scene.objects = rail ? cards_at({390, 450, 510}, 20, camera, false)
                         : cards_at({430, 418, 406}, 16, camera, true);
    made.plan.mode = StripeMode::spacetime;
    made.plan.record = RecordWhat::frames;
    made.plan.from = rail ? -14 : -0.55;
    made.plan.to = -made.plan.from;
    made.plan.step = rail ? 0.25 : 0.008;
    const double footprint_px = std::sqrt(1.0 / 12 + psf_sigma_px * psf_sigma_px);
    made.footprint_ratio = footprint_px * 450 / camera.fx / kBeamMm;
    return made;
}

RecordingContents sweep_of(const EdgeCards& cards) {
    LocalScanner scanner(cards.scene);
    return scanner.run(cards.plan);
}

std::vector<Crossing> spatial_crossings(const RecordingContents& sweep, PeakMethod method) {
    SpatialOptions options;
    options.method = method;
    std::vector<Crossing> crossings;
    for (const Frame& frame : sweep.frames)
        for (const Pulse& peak : find_peaks(frame, sweep.snapshot.device.noise, options))
            if (const auto axis = position_at(sweep.axis_log, frame.row_time(0)))
                crossings.push_back({peak.u, peak.v, axis->s});
    return crossings;
}

std::vector<Crossing> rotated_crossings(const RecordingContents& sweep, const EdgeCards& cards) {
    const ImagePath path = middle_path(cards);
    RotationOptions options;
    options.slope_px = path.du * cards.plan.step;
    options.width_frames = path.width_s / cards.plan.step;
    options.least_dn = 40;  // of 4095: a hundredth
    std::vector<double> positions;
    for (const Frame& frame : sweep.frames)
        positions.push_back(position_at(sweep.axis_log, frame.row_time(0)).value().s);
    std::vector<Crossing> crossings;
    for (int row = 0; row < sweep.frames.front().height; ++row)
        for (const SpacetimeMean& mean : rotated_spacetime_means(sweep.frames, row, options)) {
            const auto k = static_cast<std::size_t>(std::max(0.0, mean.frame));
            if (k + 1 >= positions.size()) continue;
            const double s = positions[k] + (mean.frame - static_cast<double>(k)) *
                                                (positions[k + 1] - positions[k]);
            crossings.push_back({mean.u, mean.v, s});
        }
    return crossings;
}

std::vector<Crossing> straight_crossings(const RecordingContents& sweep, const EdgeCards& cards) {
    PathTable table = make_path_table(channel_of(cards), "");
    const ImagePath path = middle_path(cards);
    std::fill(table.du_ds.begin(), table.du_ds.end(), static_cast<float>(path.du));
    std::fill(table.width_s.begin(), table.width_s.end(), static_cast<float>(path.width_s));
    for (auto* column : {&table.dv_ds, &table.d2u_ds2, &table.d2v_ds2})
        std::fill(column->begin(), column->end(), 0.0F);
    std::fill(table.valid.begin(), table.valid.end(), std::uint8_t{1});
    return pulses_along(sweep, table);
}

std::vector<Crossing> path_crossings(const RecordingContents& sweep, const EdgeCards& cards) {
    return pulses_along(sweep, make_path_table(channel_of(cards), ""));
}

std::array<double, 2> rotation_tangents(const EdgeCards& cards) {
    const Channel& channel = channel_of(cards);
    const auto hit = triangulate(channel, middle_of(cards), 0);
    const Rigid3 head = scan_from_camera(channel, 0);
    const Vector3d normal = head.rotation * sheet_at(channel, 0).normal;
    // A step carries the part past the head; the camera sees where on the sheet it seems to go.
    const Rigid3 later = scan_from_camera(channel, cards.plan.step);
    const Vector3d step = head * (later.inverse() * hit->point_in_scan) - hit->point_in_scan;
    const Vector3d seen = step - hit->ray_in_scan * normal.dot(step) / normal.dot(hit->ray_in_scan);
    const double px = seen.dot(hit->d_point_d_u) / hit->d_point_d_u.squaredNorm();
    return {1 / std::abs(px), 1 / std::abs(middle_path(cards).du * cards.plan.step)};
}

EdgeErrors judge(const std::vector<Crossing>& crossings, const EdgeCards& cards) {
    std::vector<double> errors;
    for (const Crossing& at : crossings) {
        const auto hit = triangulate(channel_of(cards), {at.u, at.v}, at.s);
        if (!hit) continue;
        for (const SceneObject& object : cards.scene.objects) {
            const Vector3d on_card = object.world_from_object.inverse() * hit->point_in_scan;
            const Vector2d half = object.size_mm / 2;
            if (std::abs(on_card.x()) > half.x() - kMarginMm ||
                std::abs(on_card.y()) > half.y() - kRowsMm || std::abs(on_card.z()) > 5)
                continue;  // cards are at least 12 mm apart
            errors.push_back(std::abs(on_card.z()));
            break;
        }
    }
    EdgeErrors told;
    told.points = errors.size();
    if (errors.empty()) return told;
    std::sort(errors.begin(), errors.end());
    double squares = 0;
    for (const double e : errors) squares += e * e;
    told.worst_mm = errors.back();
    told.p95_mm = errors[errors.size() * 95 / 100];
    told.rms_mm = std::sqrt(squares / static_cast<double>(errors.size()));
    return told;
}

void print(const std::string& what, const EdgeErrors& errors) {
    std::printf("  %-42s %6zu points, worst %.4f mm, 95 %% %.4f mm, rms %.4f mm\n", what.c_str(),
                errors.points, errors.worst_mm, errors.p95_mm, errors.rms_mm);
}

}  // namespace stria::test_support
