#include "tests/calib/synthetic_scanner.h"

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "calib/stripe_points.h"
#include "host/geometry/align.h"
#include "tests/calib/synthetic_board.h"

namespace stria {
namespace {

constexpr double kRangeMm = 500;  ///< middle of the working depth

struct Travel {
    double from, to;
};

Travel travel(MachineKind kind) {
    switch (kind) {
        case MachineKind::swept:
            return {-0.16, 0.16};
        case MachineKind::rail:
            return {-120, 120};
        case MachineKind::turntable:
            return {-0.7, 0.7};
    }
    return {};
}

/// Distance from the sheet of the board point that a pixel sees.
double distance(const Channel& channel, const Rigid3& pose, const Eigen::Vector2d& pixel,
                double s) {
    return distance_on_board(channel, pose, pixel, s);
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

bool on_board(const Channel& channel, const Rigid3& pose, const Board& board,
              const Eigen::Vector2d& pixel) {
    const Eigen::Vector3d ray = ray_through(channel.camera, pixel);
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

Pulse pulse_at(const Eigen::Vector2d& pixel, double s) {
    Pulse pulse;
    pulse.u = static_cast<float>(pixel.x());
    pulse.v = static_cast<float>(pixel.y());
    pulse.s = s;
    pulse.amplitude = 100;
    return pulse;
}

/// One cell a lattice pixel, the time of its pulse exact but for noise.
PulseMap swept_pulses(const Channel& channel, const Rigid3& pose, const Board& board,
                      const SyntheticOptions& options, std::mt19937& rng) {
    constexpr double kSpeed = 0.3;  // rad/s
    std::normal_distribution<double> noise(0, 1);
    std::uniform_real_distribution<double> unit(0, 1);
    const int step = options.pixel_step;
    const int width = channel.camera.width / step, height = channel.camera.height / step;
    const Travel range = travel(MachineKind::swept);
    PulseMap map = empty_map(StripeMode::spacetime, width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Eigen::Vector2d pixel(step * x + step / 2, step * y + step / 2);
            if (on_board(channel, pose, board, pixel)) {
                const auto f = [&](double s) { return distance(channel, pose, pixel, s); };
                if (const auto s = root(f, range.from, range.to)) {
                    const double px_per_rad = std::abs(f(*s + 1e-5) - f(*s - 1e-5)) / 2e-5 /
                                              (kRangeMm / channel.camera.fx);
                    const double sigma_s = options.stripe_noise_px / px_per_rad;
                    Pulse pulse = pulse_at(pixel, *s + sigma_s * noise(rng));
                    if (unit(rng) < options.outlier_share)
                        pulse.s = range.from + (range.to - range.from) * unit(rng);
                    pulse.ds_dt = kSpeed;
                    pulse.sigma = static_cast<float>(1e9 * sigma_s / kSpeed);
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
                     const SyntheticOptions& options, std::mt19937& rng) {
    std::normal_distribution<double> noise(0, options.stripe_noise_px);
    std::uniform_real_distribution<double> unit(0, 1);
    const Travel range = travel(channel.axis.kind);
    const int frames = options.frames, step = options.pixel_step;
    const int rows = channel.camera.height / step;
    PulseMap map = empty_map(StripeMode::spatial, frames, rows);
    for (int row = 0; row < rows; ++row)
        for (int k = 0; k < frames; ++k) {
            const double s = range.from + (range.to - range.from) * k / (frames - 1);
            const double v = step * row + step / 2;
            const auto f = [&](double u) { return distance(channel, pose, {u, v}, s); };
            const auto u = root(f, 0, channel.camera.width - 1);
            if (u && on_board(channel, board_motion(channel, s) * pose, board, {*u, v})) {
                Pulse pulse = pulse_at({*u + noise(rng), v}, s);
                if (unit(rng) < options.outlier_share) pulse.u = float(1279 * unit(rng));
                pulse.sigma = static_cast<float>(options.stripe_noise_px);
                pulse.width = 1.5F;
                map.pulses.push_back(pulse);
            }
            map.cell_begin.push_back(static_cast<std::uint32_t>(map.pulses.size()));
        }
    return map;
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

ScannerModel built_scanner(const ScannerModel& drawn, std::mt19937& rng) {
    std::normal_distribution<double> unit(0, 1);
    const auto names = parameter_names(drawn);
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(Eigen::Index(names.size()));
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
        delta[static_cast<Eigen::Index>(i)] = sigma * unit(rng);
    }
    return perturbed(drawn, delta);
}

CornerView synthetic_view(const ScannerModel& truth, const Board& board,
                          const Rigid3& camera_from_board, const std::string& name,
                          const SyntheticOptions& options, std::mt19937& rng) {
    const Channel& channel = truth.channels[0];
    const MachineKind kind = channel.axis.kind;
    const Travel range = travel(kind);
    CornerView view;
    view.name = name;
    for (int k = 0; k < options.pictures; ++k) {
        const double share = options.pictures == 1 ? 0.0 : double(k) / (options.pictures - 1);
        const double s = range.from + options.travel_share * (range.to - range.from) * share;
        const CameraView seen =
            seen_by(channel.camera, board_motion(channel, s) * camera_from_board, board,
                    options.corner_noise_px, rng);
        if (seen.ids.size() > 20)
            view.corners.push_back({name + "/" + std::to_string(k), s, seen.ids, seen.pixels});
    }
    view.pulses = kind == MachineKind::swept
                      ? swept_pulses(channel, camera_from_board, board, options, rng)
                      : peak_pulses(channel, camera_from_board, board, options, rng);
    return view;
}

std::vector<CornerView> synthetic_views(const ScannerModel& truth, const Board& board,
                                        const SyntheticOptions& options, std::mt19937& rng) {
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
    }
    return views;
}

PointError point_error(const ScannerModel& truth, const ScannerModel& found,
                       const std::vector<CornerView>& views) {
    std::vector<Eigen::Vector3d> right, ours;
    for (const CornerView& view : views)
        for (std::size_t i = 0; i < view.pulses.pulses.size(); i += 7) {
            const Pulse& pulse = view.pulses.pulses[i];
            const auto a = triangulate(truth.channels[0], {pulse.u, pulse.v}, pulse.s);
            const auto b = triangulate(found.channels[0], {pulse.u, pulse.v}, pulse.s);
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
    return error;
}

}  // namespace stria
