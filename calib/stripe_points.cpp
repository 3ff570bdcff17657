#include "calib/stripe_points.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "calib/board_drawing.h"

namespace stria {
namespace {

constexpr double kMarginMm = 1;

bool one_colour_around(const Channel& channel, const Rigid3& board_pose,
                       const BoardColours& colours, const Pulse& pulse, StripeMode mode) {
    int low = 255, high = 0;
    const auto take = [&](double du, double dv) {
        const auto p = seen_on_board(channel.camera, board_pose, {pulse.u + du, pulse.v + dv});
        const int colour = p ? colours.at(*p) : 128;
        low = std::min(low, colour);
        high = std::max(high, colour);
    };
    if (mode == StripeMode::spatial) {
        const double width = std::max(1.0, double(pulse.width));
        for (int k = -6; k <= 6; ++k) take(0.5 * k * width, 0);
        take(0, 1);
        take(0, -1);
    } else {
        for (int k = -2; k <= 2; ++k) {
            take(k, 0);
            take(0, k);
        }
    }
    return low > 200 || high < 55;
}

/// Rows or columns to step over so that a lattice of the grid's cells holds about `most` of them.
int lattice_step(const PulseMap& pulses, int most) {
    const double cells = double(pulses.width) * double(pulses.height);
    return std::max(1, static_cast<int>(std::floor(std::sqrt(cells / most))));
}

}  // namespace

std::optional<Eigen::Vector2d> seen_on_board(const CameraModel& camera,
                                             const Rigid3& camera_from_board,
                                             const Eigen::Vector2d& pixel, double height_mm) {
    const Eigen::Vector3d ray = ray_through(camera, pixel);
    const Eigen::Vector3d normal = camera_from_board.rotation.col(2);
    const double depth = (normal.dot(camera_from_board.translation) + height_mm) / normal.dot(ray);
    if (!(depth > 0) || !std::isfinite(depth)) return std::nullopt;
    const Eigen::Vector3d on_board =
        camera_from_board.rotation.transpose() * (depth * ray - camera_from_board.translation);
    return Eigen::Vector2d(on_board.head<2>());
}

Eigen::Vector2d rise_seen(const CameraModel& camera, const Rigid3& camera_from_board,
                          const Eigen::Vector2d& pixel, const BoardRise& rise,
                          const Eigen::Vector2d& warp_mm) {
    Eigen::Vector2d there = Eigen::Vector2d::Zero();
    const int rounds = warp_mm.isZero() ? 1 : 2;  // the second sees the surface, not the plane
    for (int round = 0; round < rounds; ++round) {
        const auto place = seen_on_board(camera, camera_from_board, pixel, there.dot(warp_mm));
        if (!place) return Eigen::Vector2d::Zero();
        there = rise.at(*place);
    }
    return there;
}

BoardColours::BoardColours(const Board& board) {
    const Eigen::Vector2d size = pattern_size_mm(board);
    px_per_mm_ = std::min(8.0, 2000.0 / size.maxCoeff());
    picture_ = draw_board(board, px_per_mm_, kMarginMm);
    origin_px_ = board_origin_px(board, px_per_mm_, kMarginMm);
    min_mm_ = max_mm_ = board_points(board).front().head<2>();
    for (const Eigen::Vector3d& p : board_points(board)) {
        min_mm_ = min_mm_.cwiseMin(p.head<2>());
        max_mm_ = max_mm_.cwiseMax(p.head<2>());
    }
}

bool BoardColours::is_inside(const Eigen::Vector2d& p) const {
    return (p.array() >= min_mm_.array()).all() && (p.array() <= max_mm_.array()).all();
}

int BoardColours::at(const Eigen::Vector2d& on_board) const {
    const Eigen::Vector2d pixel = origin_px_ + px_per_mm_ * on_board;
    const int x = static_cast<int>(std::lround(pixel.x()));
    const int y = static_cast<int>(std::lround(pixel.y()));
    if (x < 0 || y < 0 || x >= picture_.width || y >= picture_.height) return 128;
    return picture_.at(x, y);
}

PulseMap thinned(const PulseMap& pulses, int cells) {
    if (pulses.width == 0 || pulses.height == 0) return pulses;
    const int step = lattice_step(pulses, cells);
    PulseMap few;
    few.mode = pulses.mode;
    few.camera_id = pulses.camera_id;
    few.frames = pulses.frames;
    few.frames_dropped = pulses.frames_dropped;
    few.saturated_samples = pulses.saturated_samples;
    few.undersampled = pulses.undersampled;
    few.width = (pulses.width + step - 1) / step;
    few.height = (pulses.height + step - 1) / step;
    few.cell_begin.assign(1, 0);
    for (int y = 0; y < pulses.height; y += step)
        for (int x = 0; x < pulses.width; x += step) {
            const auto cell = pulses.cell(x, y);
            few.pulses.insert(few.pulses.end(), cell.begin(), cell.end());
            few.cell_begin.push_back(static_cast<std::uint32_t>(few.pulses.size()));
        }
    return few;
}

Rigid3 board_motion(const Channel& channel, double s) {
    return scan_from_camera(channel, s).inverse() * scan_from_camera(channel, 0);
}

std::vector<StripePoint> stripe_points_on_board(const PulseMap& pulses, const Channel& channel,
                                                const Rigid3& camera_from_board,
                                                const BoardColours& colours, int most) {
    std::vector<StripePoint> points;
    if (pulses.undersampled || pulses.width == 0 || pulses.height == 0) return points;
    const bool still = channel.axis.kind == MachineKind::swept;
    const int step = lattice_step(pulses, 20 * most);
    for (int y = 0; y < pulses.height; y += step)
        for (int x = 0; x < pulses.width; x += step) {
            const auto cell = pulses.cell(x, y);
            const auto strongest = std::find_if(
                cell.begin(), cell.end(),
                [&](const Pulse& candidate) { return candidate.laser_id == channel.laser_id; });
            if (strongest == cell.end()) continue;
            const Pulse& pulse = *strongest;
            if (pulse.flags != 0 || !(pulse.sigma > 0)) continue;
            const Rigid3 pose =
                still ? camera_from_board : board_motion(channel, pulse.s) * camera_from_board;
            const auto on_board = seen_on_board(channel.camera, pose, {pulse.u, pulse.v});
            if (!on_board || !colours.is_inside(*on_board)) continue;
            if (!one_colour_around(channel, pose, colours, pulse, pulses.mode)) continue;
            const double sigma = pulses.mode == StripeMode::spacetime
                                     ? std::abs(pulse.ds_dt) * 1e-9 * double(pulse.sigma)
                                     : double(pulse.sigma);
            if (!(sigma > 0)) continue;
            points.push_back({{pulse.u, pulse.v}, pulse.s, pulses.mode, sigma, pulse.ds_dt});
        }
    const auto limit = static_cast<std::size_t>(most);
    if (points.size() <= limit) return points;
    std::vector<StripePoint> thinned;
    for (std::size_t i = 0; i < limit; ++i) thinned.push_back(points[i * points.size() / limit]);
    return thinned;
}

double distance_on_board(const Channel& channel, const Rigid3& camera_from_board,
                         const Eigen::Vector2d& pixel, double s, double height_mm) {
    const Rigid3 pose = board_motion(channel, s) * camera_from_board;
    const Eigen::Vector3d ray = ray_through(channel.camera, pixel);
    const Eigen::Vector3d normal = pose.rotation.col(2);
    return signed_distance(sheet_at(channel, s),
                           ray * ((normal.dot(pose.translation) + height_mm) / normal.dot(ray)));
}

double sigma_on_board_mm(const Channel& channel, const Rigid3& camera_from_board,
                         const StripePoint& point) {
    const bool in_time = point.mode == StripeMode::spacetime;
    const double h = in_time ? (channel.axis.kind == MachineKind::rail ? 1e-3 : 1e-5) : 0.05;
    const Eigen::Vector2d step(in_time ? 0 : h, 0);
    const double ds = in_time ? h : 0, s = axis_position(point, channel.axis);
    const double after = distance_on_board(channel, camera_from_board, point.pixel + step, s + ds);
    const double before = distance_on_board(channel, camera_from_board, point.pixel - step, s - ds);
    return std::abs(after - before) / (2 * h) * point.sigma;
}

}  // namespace stria
