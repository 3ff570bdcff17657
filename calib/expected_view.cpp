#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "calib/camera_calibration.h"
#include "calib/linear_view.h"

namespace stria {
namespace {

/// Axis position at which the sheet's middle passes that board point.
std::optional<double> crossing(const Channel& channel, const Rigid3& pose,
                               const Eigen::Vector3d& on_board, double from, double to) {
    const auto distance = [&](double s) {
        return signed_distance(sheet_at(channel, s), board_motion(channel, s) * (pose * on_board));
    };
    constexpr int kPieces = 8;
    double low = from, at_low = distance(low);
    for (int i = 1; i <= kPieces; ++i) {
        double high = from + (to - from) * i / kPieces, at_high = distance(high);
        if (at_low * at_high <= 0 && at_low != at_high) {
            for (int round = 0; round < 30; ++round) {
                const double middle = 0.5 * (low + high), at = distance(middle);
                ((at < 0) == (at_low < 0) ? low : high) = middle;
            }
            return 0.5 * (low + high);
        }
        low = high;
        at_low = at_high;
    }
    return std::nullopt;
}

bool faces(const Rigid3& pose, const Eigen::Vector3d& point, double least_cosine) {
    return pose.rotation.col(2).dot(point) > least_cosine * point.norm();
}

/// Millimetres that the stripe's point on the board lies off the sheet for a pixel along the row.
double mm_per_px(const Channel& channel, const Rigid3& pose, const Eigen::Vector2d& pixel,
                 double s) {
    constexpr double kStep = 0.5;
    const Eigen::Vector2d aside(kStep, 0);
    return std::abs(distance_on_board(channel, pose, pixel + aside, s) -
                    distance_on_board(channel, pose, pixel - aside, s)) /
           (2 * kStep);
}

/// Thins to about `most` and makes each count for what was left out.
template <typename Point, typename Sigma>
void thin(std::vector<Point>& points, int most, const Sigma& sigma) {
    const std::size_t every = std::max<std::size_t>(1, points.size() / std::size_t(most));
    std::vector<Point> kept;
    for (std::size_t i = every / 2; i < points.size(); i += every) kept.push_back(points[i]);
    for (Point& point : kept)
        sigma(point) /= std::sqrt(double(points.size()) / double(kept.size()));
    points = std::move(kept);
}

/// Whether a picture shows the whole board with a border of one square or circle: without markers
/// it is found whole or not at all.
bool shows_all(const Channel& channel, const Rigid3& pose, const Board& board,
               const std::vector<Eigen::Vector3d>& points) {
    Eigen::Vector3d low = points.front(), high = low;
    for (const Eigen::Vector3d& point : points) {
        low = low.cwiseMin(point);
        high = high.cwiseMax(point);
    }
    const double border = 1.5 * board.pitch_mm;
    for (const double x : {low.x() - border, high.x() + border})
        for (const double y : {low.y() - border, high.y() + border}) {
            const auto pixel = project(channel.camera, pose * Eigen::Vector3d(x, y, 0));
            if (!pixel || !channel.camera.contains(*pixel)) return false;
        }
    return true;
}

void add_corners(const Channel& channel, const Board& board,
                 const std::vector<Eigen::Vector3d>& points, const ViewPlan& plan,
                 double least_seen, ViewData& view) {
    for (const double s : plan.picture_s) {
        const Rigid3 pose = board_motion(channel, s) * view.camera_from_board;
        if (board.kind != BoardKind::charuco && !shows_all(channel, pose, board, points)) continue;
        for (const Eigen::Vector3d& point : points) {
            const Eigen::Vector3d in_camera = pose * point;
            const auto pixel = project(channel.camera, in_camera);
            if (pixel && channel.camera.contains(*pixel) &&
                faces(pose, in_camera, plan.least_facing))
                view.corners.push_back({point, *pixel, s, plan.corner_sigma_px});
        }
    }
    const double all = static_cast<double>(points.size() * plan.picture_s.size());
    if (static_cast<double>(view.corners.size()) < least_seen * all) view.corners.clear();
}

void add_stripes(const Channel& channel, const std::vector<Eigen::Vector3d>& points,
                 const ViewPlan& plan, ViewData& view) {
    for (const Eigen::Vector3d& point : points) {
        const auto s =
            crossing(channel, view.camera_from_board, point, plan.sweep_from, plan.sweep_to);
        if (!s) continue;
        const Rigid3 pose = board_motion(channel, *s) * view.camera_from_board;
        const Eigen::Vector3d in_camera = pose * point;
        const auto pixel = project(channel.camera, in_camera);
        if (!pixel || !channel.camera.contains(*pixel) ||
            !faces(pose, in_camera, plan.least_facing))
            continue;
        const double slope = mm_per_px(channel, view.camera_from_board, *pixel, *s);
        if (slope > 0 && std::isfinite(slope))
            view.stripes.push_back(
                {*pixel, *s,
                 plan.stripe_sigma_mm > 0 ? plan.stripe_sigma_mm : slope * plan.stripe_sigma_px});
    }
}

}  // namespace

ViewData expected_view(const ScannerModel& model, const Board& board,
                       const Rigid3& camera_from_board, const ViewPlan& plan, double least_seen) {
    const Channel& channel = model.channels.front();
    const auto points = board_points(board);
    ViewData view;
    view.camera_from_board = camera_from_board;
    add_corners(channel, board, points, plan, least_seen, view);
    if (!view.corners.empty()) add_stripes(channel, points, plan, view);
    if (view.stripes.empty()) view.corners.clear();
    if (view.corners.empty()) return view;
    thin(view.corners, plan.most_corners,
         [](ViewData::Corner& corner) -> double& { return corner.sigma_px; });
    thin(view.stripes, plan.most_stripes,
         [](ViewData::Stripe& stripe) -> double& { return stripe.sigma_mm; });
    return view;
}

ViewData measured_view(const ScannerModel& model, const Board& board, const CornerView& view,
                       double corner_sigma_px, double stripe_sigma_factor, int most_stripes) {
    const Channel& channel = model.channels.front();
    const auto points = board_points(board);
    ViewData data;
    bool placed = false;
    for (const BoardCorners& seen : view.corners) {
        if (!placed) {
            const auto pose = board_pose(channel.camera, {"", seen.ids, seen.pixels, {}}, board);
            if (!pose) continue;
            data.camera_from_board = board_motion(channel, seen.s).inverse() * *pose;
            placed = true;
        }
        for (std::size_t i = 0; i < seen.ids.size(); ++i)
            data.corners.push_back({points[static_cast<std::size_t>(seen.ids[i])], seen.pixels[i],
                                    seen.s, corner_sigma_px});
    }
    if (!placed) return data;
    const BoardRise rise(points);
    for (const StripePoint& point : stripe_points_on_board(
             view.pulses, channel, data.camera_from_board, BoardColours(board), most_stripes)) {
        const Rigid3 at_s = board_motion(channel, point.s) * data.camera_from_board;
        data.stripes.push_back(
            {point.pixel, point.s,
             stripe_sigma_factor * sigma_on_board_mm(channel, data.camera_from_board, point),
             rise_seen(channel.camera, at_s, point.pixel, rise, board.warp_mm).dot(board.warp_mm)});
    }
    return data;
}

}  // namespace stria
