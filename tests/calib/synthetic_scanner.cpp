#include "tests/calib/synthetic_scanner.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <set>

#include "calib/stripe_points.h"
#include "firmware/core/angle.h"
#include "host/geometry/align.h"
#include "tests/calib/synthetic_board.h"

namespace stria {
namespace {

constexpr double kRangeMm = 500;  ///< middle of the working depth

struct Travel {
    double from, to;
};

Travel travel(MachineKind kind, const SyntheticOptions& options) {
    switch (kind) {
        case MachineKind::swept:
            return {-0.16, 0.16};
        case MachineKind::rail:
            return {-120, 120};
        case MachineKind::turntable:
            return {-0.5 * options.turn_rad, 0.5 * options.turn_rad};
    }
    return {};
}

/// Distance from the sheet of the board point that a pixel sees.
double distance(const Channel& channel, const Rigid3& pose, const Board& board,
                const BoardRise& rise, const Eigen::Vector2d& pixel, double s) {
    if (board.warp_mm.isZero()) return distance_on_board(channel, pose, pixel, s);
    const Rigid3 at_s = board_motion(channel, s) * pose;
    const Eigen::Vector3d ray = ray_through(channel.camera, pixel), n = at_s.rotation.col(2);
    double height = 0;
    Eigen::Vector3d seen;
    for (int round = 0; round < 8; ++round) {  // each round is right to a hundredth of the last
        seen = ray * ((n.dot(at_s.translation) + height) / n.dot(ray));
        const Eigen::Vector3d p = at_s.rotation.transpose() * (seen - at_s.translation);
        height = rise.at(p.head<2>()).dot(board.warp_mm);
    }
    return signed_distance(sheet_at(channel, s), seen);
}

/// Root of f in [low, high] by bisection and secants; empty without a change of sign.
template <typename F>
std::optional<double> root(F&& f, double low, double high) {
    double at_low = f(low), at_high = f(high);
    if (!(at_low * at_high < 0)) return std::nullopt;
    for (int i = 0; i < 80 && high - low > 1e-13 * (1 + std::abs(low)); ++i) {
        double x = low - at_low * (high - low) / (at_high - at_low);
        if (i % 3 == 2 || !(x > low && x < high)) x = 0.5 * (low + high);
        const double y = f(x);
        if ((y < 0) == (at_low < 0)) {
            low = x;
            at_low = y;
        } else {
            high = x;
            at_high = y;
        }
        if (y == 0) return x;
    }
    return 0.5 * (low + high);
}

bool faces_camera(const Rigid3& pose, const Eigen::Vector3d& ray) {
    constexpr double kLeastCosine = 0.2588;  // of 75 deg
    return pose.rotation.col(2).dot(ray) > kLeastCosine * ray.norm();
}

bool on_board(const Channel& channel, const Rigid3& pose, const Board& board,
              const Eigen::Vector2d& pixel) {
    const Eigen::Vector3d ray = ray_through(channel.camera, pixel);
    if (!faces_camera(pose, ray)) return false;
    const Eigen::Vector3d n = pose.rotation.col(2);
    const Eigen::Vector3d p = pose.rotation.transpose() *
                              (ray * (n.dot(pose.translation) / n.dot(ray)) - pose.translation);
    const Eigen::Vector3d last = board_points(board).back();
    const double edge = board.pitch_mm;
    return p.x() > -edge && p.y() > -edge && p.x() < last.x() + edge && p.y() < last.y() + edge;
}

PulseMap empty_map(StripeMode mode, int width, int height) {
    PulseMap map;
    map.mode = mode;
    map.width = width;
    map.height = height;
    map.cell_begin.push_back(0);
    return map;
}

Pulse pulse_at(const Channel& channel, const Eigen::Vector2d& pixel, double s, double ds_dt) {
    Pulse pulse;
    pulse.u = static_cast<float>(pixel.x());
    pulse.v = static_cast<float>(pixel.y());
    pulse.s = s - ds_dt * 1e-9 * channel.axis.delay_ns;
    pulse.ds_dt = ds_dt;
    pulse.amplitude = 100;
    pulse.laser_id = channel.laser_id;
    return pulse;
}

/// One cell a lattice pixel, the time of its pulse exact but for noise.
/// @param direction  1 or -1
PulseMap swept_pulses(const Channel& channel, const Rigid3& pose, const Board& board,
                      const SyntheticOptions& options, int direction, std::mt19937& rng) {
    const double speed = 0.3 * direction;  // rad/s
    std::normal_distribution<double> noise(0, options.noisy ? 1 : 1e-12);
    std::uniform_real_distribution<double> unit(0, 1);
    const int step = options.pixel_step;
    const int width = channel.camera.width / step, height = channel.camera.height / step;
    const Travel range = travel(MachineKind::swept, options);
    PulseMap map = empty_map(StripeMode::spacetime, width, height);
    const BoardRise rise(board_points(board));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Eigen::Vector2d pixel(step * x + step / 2, step * y + step / 2);
            if (on_board(channel, pose, board, pixel)) {
                const auto f = [&](double s) {
                    return distance(channel, pose, board, rise, pixel, s);
                };
                if (const auto s = root(f, range.from, range.to)) {
                    const double px_per_rad = std::abs(f(*s + 1e-5) - f(*s - 1e-5)) / 2e-5 /
                                              (kRangeMm / channel.camera.fx);
                    const double sigma_s = options.stripe_noise_px / px_per_rad;
                    Pulse pulse = pulse_at(channel, pixel, *s + sigma_s * noise(rng), speed);
                    if (unit(rng) < options.outlier_share)
                        pulse.s = range.from + (range.to - range.from) * unit(rng);
                    pulse.sigma = static_cast<float>(1e9 * sigma_s / std::abs(speed));
                    pulse.width = 10 * pulse.sigma;
                    map.pulses.push_back(pulse);
                }
            }
            map.cell_begin.push_back(static_cast<std::uint32_t>(map.pulses.size()));
        }
    return map;
}

/// One cell a frame and image row, u of its peak.
PulseMap peak_pulses(const Channel& channel, const Rigid3& pose, const Board& board,
                     const SyntheticOptions& options, int direction, std::mt19937& rng) {
    std::normal_distribution<double> noise(0, options.noisy ? options.stripe_noise_px : 1e-12);
    std::uniform_real_distribution<double> unit(0, 1);
    const Travel range = travel(channel.axis.kind, options);
    const double speed = direction * (channel.axis.kind == MachineKind::rail ? 20 : 0.2);
    const int frames = options.frames, step = options.pixel_step;
    const int rows = channel.camera.height / step;
    PulseMap map = empty_map(StripeMode::spatial, frames, rows);
    const BoardRise rise(board_points(board));
    for (int row = 0; row < rows; ++row)
        for (int k = 0; k < frames; ++k) {
            const double s = range.from + (range.to - range.from) * k / (frames - 1);
            const double v = step * row + step / 2;
            const auto f = [&](double u) {
                return distance(channel, pose, board, rise, {u, v}, s);
            };
            const auto u = root(f, 0, channel.camera.width - 1);
            if (u && on_board(channel, board_motion(channel, s) * pose, board, {*u, v})) {
                Pulse pulse = pulse_at(channel, {*u + noise(rng), v}, s, speed);
                if (unit(rng) < options.outlier_share) pulse.u = float(1279 * unit(rng));
                pulse.sigma = static_cast<float>(options.stripe_noise_px);
                pulse.width = 1.5F;
                map.pulses.push_back(pulse);
            }
            map.cell_begin.push_back(static_cast<std::uint32_t>(map.pulses.size()));
        }
    return map;
}

/// The passes of every laser in every direction over one placement of the board.
std::vector<PulseMap> passes_over(const ScannerModel& truth, const Rigid3& pose, const Board& board,
                                  const SyntheticOptions& options, std::mt19937& rng) {
    std::vector<PulseMap> passes;
    for (const Channel& channel : truth.channels)
        for (const int direction : {1, -1})
            if (direction > 0 || options.both_directions)
                passes.push_back(channel.axis.kind == MachineKind::swept
                                     ? swept_pulses(channel, pose, board, options, direction, rng)
                                     : peak_pulses(channel, pose, board, options, direction, rng));
    return passes;
}

/// Calls use(map, pulse, channel) for every pulse of the views.
template <typename Use>
void for_each_pulse(const ScannerModel& truth, const std::vector<CornerView>& views,
                    const Use& use) {
    const auto through = [&](const PulseMap& map) {
        for (const Pulse& pulse : map.pulses)
            for (std::size_t c = 0; c < truth.channels.size(); ++c)
                if (truth.channels[c].laser_id == pulse.laser_id) use(pulse, c);
    };
    for (const CornerView& view : views) {
        through(view.pulses);
        for (const PulseMap& map : view.further_passes) through(map);
    }
}

/// Turns and shifts what is given in the found camera's frame into the true one's, as well as the
/// samples' points there (before any axis moves them) tell.
Rigid3 true_from_found_camera(const ScannerModel& truth, const ScannerModel& found,
                              const std::vector<VolumeSample>& samples) {
    std::vector<Eigen::Vector3d> right, ours;
    for (const VolumeSample& sample : samples) {
        const Channel &a = truth.channels[sample.channel], &b = found.channels[sample.channel];
        const auto p = triangulate(a, sample.pixel, sample.s);
        const auto q = triangulate(b, sample.pixel, sample.s);
        if (!p || !q) continue;
        right.push_back(scan_from_camera(a, sample.s).inverse() * p->point_in_scan);
        ours.push_back(scan_from_camera(b, sample.s).inverse() * q->point_in_scan);
    }
    return align_points(ours, right);
}

void compare_axes(const ScannerModel& truth, const ScannerModel& found,
                  const std::vector<VolumeSample>& samples, const Eigen::Vector3d& middle_in_scan,
                  PointError& error) {
    const AxisModel &right = truth.channels[0].axis, &ours = found.channels[0].axis;
    if (right.kind == MachineKind::swept) return;
    const Rigid3 motion = true_from_found_camera(truth, found, samples);
    if (right.kind == MachineKind::rail) {
        const Eigen::Vector3d d = motion.rotation * ours.rail.direction;
        error.axis_deg = d.cross(right.rail.direction).norm() / kDegree;
        return;
    }
    const Rigid3 table = right.turntable.table_from_camera * motion *
                         ours.turntable.table_from_camera.inverse();  // true from found table
    const Eigen::Vector3d up = table.rotation.col(2);
    error.axis_deg = up.cross(Eigen::Vector3d::UnitZ()).norm() / kDegree;
    const Eigen::Vector3d at =
        table.translation + up * (middle_in_scan.z() - table.translation.z()) / up.z();
    error.axis_mm = at.head<2>().norm();
}

}  // namespace

ScannerModel drawn_scanner(MachineKind kind) {
    ScannerModel model;
    model.channels.resize(1);
    Channel& channel = model.channels[0];
    channel.camera = {.kind = LensKind::brown5,
                      .width = 1280,
                      .height = 1024,
                      .fx = 1500,
                      .fy = 1500,
                      .cx = 639.5,
                      .cy = 511.5};
    channel.axis.kind = kind;
    const Eigen::Vector3d side(200, 0, 0);
    const Eigen::Vector3d outgoing = (Eigen::Vector3d(0, 0, kRangeMm) - side).normalized();
    LaserSheet& sheet = channel.sheet;
    if (kind == MachineKind::swept) {
        const Eigen::Vector3d incoming(-1, 0, 0), mirror_at(200, 0, 30);
        sheet.normal = Eigen::Vector3d::UnitZ();
        sheet.apex = Eigen::Vector3d(320, 0, 30);
        sheet.central_ray = incoming;
        MirrorAxis& mirror = channel.axis.mirror;
        mirror.direction = Eigen::Vector3d::UnitY();
        mirror.point = mirror_at;
        mirror.normal0 = (outgoing - incoming).normalized();
        mirror.offset_mm = 2;
    } else {
        sheet.normal = Eigen::Vector3d::UnitY().cross(outgoing);
        sheet.apex = side;
        sheet.central_ray = outgoing;
        channel.axis.rail.direction = Eigen::Vector3d::UnitX();
        // Table below the camera's axis, seen from 30 deg above: z up along the axis.
        Rigid3 camera_from_table;
        const Eigen::Vector3d up = Eigen::Vector3d(0, -0.866, -0.5).normalized();
        camera_from_table.rotation.col(2) = up;
        camera_from_table.rotation.col(0) = Eigen::Vector3d::UnitX();
        camera_from_table.rotation.col(1) = up.cross(Eigen::Vector3d::UnitX());
        camera_from_table.translation = Eigen::Vector3d(0, 60, kRangeMm + 20);
        channel.axis.turntable.table_from_camera = camera_from_table.inverse();
    }
    sheet.offset_mm = sheet.normal.dot(sheet.apex);
    sheet = normalised(sheet);
    return model;
}

ScannerModel drawn_with_two_lasers(MachineKind kind) {
    ScannerModel model = drawn_scanner(kind);
    Channel second = model.channels[0];
    second.laser_id = 1;
    LaserSheet& sheet = second.sheet;
    if (kind == MachineKind::swept) {
        const MirrorAxis& mirror = second.axis.mirror;
        const Eigen::Matrix3d turn = rotation_from_vector(0.1 * mirror.direction);
        sheet.normal = turn * sheet.normal;
        sheet.central_ray = turn * sheet.central_ray;
        sheet.apex = mirror.point + turn * (sheet.apex - mirror.point);
    } else {
        const Eigen::Vector3d to_other_side(-1, 1, 1);
        sheet.normal = to_other_side.cwiseProduct(sheet.normal);
        sheet.central_ray = to_other_side.cwiseProduct(sheet.central_ray);
        sheet.apex = to_other_side.cwiseProduct(sheet.apex);
    }
    sheet.offset_mm = sheet.normal.dot(sheet.apex);
    sheet = normalised(sheet);
    model.channels.push_back(second);
    return model;
}

Eigen::VectorXd building_sigma(const ScannerModel& drawn) {
    const auto names = parameter_names(drawn);
    Eigen::VectorXd sigmas(Eigen::Index(names.size()));
    const auto has = [](const std::string& name, const char* part) {
        return name.find(part) != std::string::npos;
    };
    for (std::size_t i = 0; i < names.size(); ++i) {
        const std::string& name = names[i];
        double sigma = 0;
        if (has(name, "camera.f"))
            sigma = 15;
        else if (has(name, "camera.c"))
            sigma = 8;
        else if (has(name, "camera.k1") || has(name, "camera.k2"))
            sigma = 0.05;
        else if (has(name, "camera.k3"))
            sigma = 0.02;
        else if (has(name, "camera.p"))
            sigma = 3e-4;
        else if (has(name, "bow"))
            sigma = 5e-4;
        else if (has(name, "mirror.g"))
            sigma = 0.02;
        else if (has(name, "point") || has(name, "offset") || has(name, "table.t"))
            sigma = 3;
        else if (has(name, "delay"))
            sigma = 0;
        else
            sigma = 0.02;  // rad, the angles
        sigmas[static_cast<Eigen::Index>(i)] = sigma;
    }
    return sigmas;
}

ScannerModel built_scanner(const ScannerModel& drawn, std::mt19937& rng) {
    std::normal_distribution<double> unit(0, 1);
    Eigen::VectorXd delta = building_sigma(drawn);
    for (double& value : delta) value *= unit(rng);
    ScannerModel built = perturbed(drawn, delta);
    for (Channel& channel : built.channels) {
        channel.camera = built.channels[0].camera;
        channel.axis = built.channels[0].axis;
    }
    return built;
}

CornerView synthetic_view(const ScannerModel& truth, const Board& board,
                          const Rigid3& camera_from_board, const std::string& name,
                          const SyntheticOptions& options, std::mt19937& rng) {
    const Channel& channel = truth.channels[0];
    const MachineKind kind = channel.axis.kind;
    const Travel range = travel(kind, options);
    CornerView view;
    view.name = name;
    for (int k = 0; k < options.pictures; ++k) {
        const double share = options.pictures == 1 ? 0.0 : double(k) / (options.pictures - 1);
        const double s = range.from + options.travel_share * (range.to - range.from) * share;
        const Rigid3 pose_at_s = board_motion(channel, s) * camera_from_board;
        const CameraView seen = seen_by(channel.camera, pose_at_s, board,
                                        options.noisy ? options.corner_noise_px : 1e-12, rng);
        if (seen.ids.size() > 20 && faces_camera(pose_at_s, pose_at_s.translation))
            view.corners.push_back({name + "/" + std::to_string(k), s, seen.ids, seen.pixels});
    }
    std::vector<PulseMap> passes = passes_over(truth, camera_from_board, board, options, rng);
    view.pulses = std::move(passes.front());
    view.further_passes.assign(std::make_move_iterator(passes.begin() + 1),
                               std::make_move_iterator(passes.end()));
    return view;
}

std::vector<CornerView> synthetic_views(const ScannerModel& truth, const Board& board,
                                        const SyntheticOptions& options, std::mt19937& rng,
                                        std::vector<Rigid3>* poses) {
    const MachineKind kind = truth.channels[0].axis.kind;
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<CornerView> views;
    for (int v = 0; v < options.views; ++v) {
        const double depth = kRangeMm + (kind == MachineKind::turntable ? 40 : 80) * unit(rng);
        const double aside = kind == MachineKind::turntable ? 20 : 50;
        const Eigen::Vector3d centre(aside * unit(rng), 40 * unit(rng), depth);
        const Rigid3 pose = random_board_pose(rng, board, centre, options.max_tilt_rad, 3.14159);
        views.push_back(
            synthetic_view(truth, board, pose, "view " + std::to_string(v), options, rng));
        if (poses) poses->push_back(pose);
    }
    return views;
}

std::vector<CornerView> with_noise(std::vector<CornerView> views, double corner_noise_px,
                                   std::mt19937& rng) {
    std::normal_distribution<double> unit(0, 1);
    const auto shake = [&](PulseMap& map) {
        for (Pulse& pulse : map.pulses)
            if (map.mode == StripeMode::spacetime)
                pulse.s += std::abs(pulse.ds_dt) * 1e-9 * double(pulse.sigma) * unit(rng);
            else
                pulse.u = static_cast<float>(pulse.u + double(pulse.sigma) * unit(rng));
    };
    for (CornerView& view : views) {
        for (BoardCorners& seen : view.corners)
            for (Eigen::Vector2d& pixel : seen.pixels)
                pixel += corner_noise_px * Eigen::Vector2d(unit(rng), unit(rng));
        shake(view.pulses);
        for (PulseMap& map : view.further_passes) shake(map);
    }
    return views;
}

ScannerCalibrationOptions options_of_built_scanners() {
    return {.nominal_angle_sigma_rad = 0.02,
            .nominal_length_sigma_mm = 3,
            .bow_sigma = 5e-4,
            .gain_sigma = 0.02};
}

std::vector<VolumeSample> volume_voxels(const ScannerModel& truth,
                                        const std::vector<CornerView>& views) {
    std::vector<VolumeSample> all;
    std::vector<Eigen::Vector3d> points;
    for_each_pulse(truth, views, [&](const Pulse& pulse, std::size_t c) {
        const double s = pulse.s + pulse.ds_dt * 1e-9 * truth.channels[c].axis.delay_ns;
        const auto spot = triangulate(truth.channels[c], {pulse.u, pulse.v}, s);
        if (!spot) return;
        all.push_back({{pulse.u, pulse.v}, s, c});
        points.push_back(spot->point_in_scan);
    });
    if (points.empty()) return {};
    Eigen::Vector3d low = points.front(), high = low;
    for (const auto& p : points) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    const double edge = (high - low).norm() / 24;
    std::set<std::array<int, 4>> seen;
    std::vector<VolumeSample> kept;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3i at = ((points[i] - low) / edge).array().floor().cast<int>();
        if (seen.insert({at.x(), at.y(), at.z(), int(all[i].channel)}).second)
            kept.push_back(all[i]);
    }
    return kept;
}

PointError point_error(const ScannerModel& truth, const ScannerModel& found,
                       const std::vector<VolumeSample>& samples) {
    std::vector<Eigen::Vector3d> right, ours;
    for (const VolumeSample& sample : samples) {
        const auto a = triangulate(truth.channels[sample.channel], sample.pixel, sample.s);
        const auto b = triangulate(found.channels[sample.channel], sample.pixel, sample.s);
        if (!a || !b) continue;
        right.push_back(a->point_in_scan);
        ours.push_back(b->point_in_scan);
    }
    const Rigid3 motion = align_points(ours, right);
    PointError error;
    Eigen::Vector3d low = right.front(), high = low;
    double sum = 0;
    for (std::size_t i = 0; i < right.size(); ++i) {
        const double e = (motion * ours[i] - right[i]).norm();
        sum += e * e;
        error.max_mm = std::max(error.max_mm, e);
        low = low.cwiseMin(right[i]);
        high = high.cwiseMax(right[i]);
    }
    error.rms_mm = std::sqrt(sum / static_cast<double>(right.size()));
    error.diagonal_mm = (high - low).norm();
    compare_axes(truth, found, samples, 0.5 * (low + high), error);
    return error;
}

PointError point_error(const ScannerModel& truth, const ScannerModel& found,
                       const std::vector<CornerView>& views) {
    return point_error(truth, found, volume_voxels(truth, views));
}

}  // namespace stria
