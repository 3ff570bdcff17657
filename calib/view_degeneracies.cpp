#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calib/axis_start.h"
#include "calib/camera_calibration.h"
#include "calib/degeneracies.h"
#include "calib/stripe_points.h"
#include "host/core/short_number.h"

namespace stria {
namespace {

constexpr double kSameTurnRad = 0.035;    ///< 2 deg
constexpr double kSamePlaceShare = 0.01;  ///< of the distance
constexpr std::size_t kLeastViews = 3;    ///< different ones
/// Of a rail or table. The nominal lens (focal length 1 %, no distortion) bends it by up to 3 % in
/// 50 good sets; what is less is told with the solved lens, as a warning of the calibration.
constexpr double kScaleTolerance = 0.04;
constexpr double kMirrorTolerance = 0.15;  ///< its axis may be 10 mm off
constexpr double kRatioTolerance = 0.03;
constexpr int kStripePoints = 200;  ///< a view

/// Views with their boards, as the nominal camera sees them.
struct Examined {
    Channel channel;  ///< nominal, the axis started from the boards' motion
    AxisStart axis;
    std::vector<Rigid3> first;  ///< camera_from_board of each view's first picture
    std::vector<double> first_s;
    std::vector<const PulseMap*> pulses;
    CalibrationCoverage seen;
};

Examined examine(const std::vector<CornerView>& views, const Board& board,
                 const ScannerModel& nominal) {
    Examined all;
    all.channel = nominal.channels.front();
    std::vector<PosesAlongAxis> along;
    for (const CornerView& view : views) {
        PosesAlongAxis poses;
        for (const BoardCorners& seen : view.corners) {
            const auto pose =
                board_pose(all.channel.camera, {"", seen.ids, seen.pixels, {}}, board);
            if (!pose) continue;
            poses.s.push_back(seen.s);
            poses.camera_from_board.push_back(*pose);
            all.seen.board_normals.push_back(pose->rotation.col(2));
            all.seen.picture_s.push_back(seen.s);
            all.seen.corner_pixels.insert(all.seen.corner_pixels.end(), seen.pixels.begin(),
                                          seen.pixels.end());
        }
        if (poses.s.empty()) continue;
        all.first.push_back(poses.camera_from_board.front());
        all.first_s.push_back(poses.s.front());
        all.pulses.push_back(&view.pulses);
        along.push_back(std::move(poses));
    }
    all.axis = start_axis(all.channel.axis, along);
    all.channel.axis = all.axis.axis;
    return all;
}

bool are_alike(const Rigid3& a, const Rigid3& b) {
    const double turn =
        Eigen::AngleAxisd(Eigen::Matrix3d(a.rotation.transpose() * b.rotation)).angle();
    return std::abs(turn) < kSameTurnRad &&
           (a.translation - b.translation).norm() < kSamePlaceShare * a.translation.norm();
}

std::size_t different_views(const Examined& all) {
    std::vector<Rigid3> kinds;
    for (std::size_t i = 0; i < all.first.size(); ++i) {
        const Rigid3 pose = board_motion(all.channel, all.first_s[i]).inverse() * all.first[i];
        const auto known = [&](const Rigid3& other) { return are_alike(pose, other); };
        if (std::none_of(kinds.begin(), kinds.end(), known)) kinds.push_back(pose);
    }
    return kinds.size();
}

std::optional<DegeneracyFinding> judge_count(const Examined& all) {
    const std::size_t views = all.first.size();
    if (views == 1)
        return DegeneracyFinding{Degeneracy::one_view, true,
                                 "one view only shows the board: take 10 to 20, the board tilted "
                                 "20 to 40 deg to different sides, near and far"};
    const std::size_t different = different_views(all);
    if (different == 1)
        return DegeneracyFinding{
            Degeneracy::same_view, true,
            "the board stands at the same place in all " + std::to_string(views) +
                " views: move it between them, tilted 20 to 40 deg to different sides, near and "
                "far"};
    if (different < kLeastViews)
        return DegeneracyFinding{Degeneracy::too_few_views, true,
                                 "only " + std::to_string(different) + " different views of " +
                                     std::to_string(views) +
                                     " show the board: at least 3 are needed, 10 to 20 are good; "
                                     "add views with the board tilted to other sides"};
    return std::nullopt;
}

/// True if a ratio looks like gears or steps confused: a small whole number or its inverse.
bool is_step_ratio(double ratio) {
    const double times = ratio > 1 ? ratio : 1 / ratio;
    for (const double whole : {2., 3., 4., 5., 8., 10., 16., 32., 64., 128., 256.})
        if (std::abs(times / whole - 1) < kRatioTolerance) return true;
    return false;
}

std::optional<DegeneracyFinding> judge_moved_scale(const Examined& all, const Board& board) {
    const double scale = all.axis.scale;
    if (!all.axis.from_views || std::abs(scale - 1) < kScaleTolerance) return std::nullopt;
    const bool table = all.channel.axis.kind == MachineKind::turntable;
    if (table || is_step_ratio(scale))
        return DegeneracyFinding{Degeneracy::axis_constant, true,
                                 std::string("the board moved ") + short_number(scale) +
                                     " times as far as the axis says: check the " +
                                     (table ? "steps per turn" : "steps per mm") +
                                     " of the axis (gear, microsteps)"};
    return DegeneracyFinding{
        Degeneracy::square_size, true,
        "the board moved " + short_number(scale) +
            " times as far as the rail says: its squares were "
            "stated as " +
            short_number(board.pitch_mm) + " mm, " + short_number(board.pitch_mm / scale) +
            " mm would fit the rail; measure the print (printed at 100 %?), then the rail's steps "
            "per mm"};
}

/// The stripe points' angle about the nominal mirror axis grows by 2 s: its least-squares slope
/// over 2 is the scale of s. Light that leaves beside the axis changes it by a few percent.
std::optional<DegeneracyFinding> judge_mirror(const Channel& channel,
                                              const std::vector<Eigen::Vector3d>& points,
                                              const std::vector<double>& positions) {
    if (points.size() < 20) return std::nullopt;
    Eigen::Vector3d a, b;
    tangent_basis(channel.axis.mirror.direction, a, b);
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    double mean_s = 0;
    const double share = 1 / static_cast<double>(points.size());
    for (const auto& p : points) middle += share * (p - channel.axis.mirror.point);
    for (double s : positions) mean_s += share * s;
    const double zero = std::atan2(middle.dot(b), middle.dot(a));
    double across = 0, squares = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3d p = points[i] - channel.axis.mirror.point;
        const double angle =
            std::remainder(std::atan2(p.dot(b), p.dot(a)) - zero, 6.283185307179586);
        across += angle * (positions[i] - mean_s);
        squares += (positions[i] - mean_s) * (positions[i] - mean_s);
    }
    const auto [low, high] = std::minmax_element(positions.begin(), positions.end());
    if (*high - *low < 0.035)
        return DegeneracyFinding{Degeneracy::narrow_sweep, false,
                                 "the stripe met the boards over " +
                                     short_number((*high - *low) * 57.29577951) +
                                     " deg of the mirror's turn only: bring the board to both "
                                     "sides of the image"};
    const double scale = std::abs(across / squares) / 2;
    if (std::abs(scale - 1) < kMirrorTolerance) return std::nullopt;
    return DegeneracyFinding{Degeneracy::axis_constant, true,
                             "the stripe turned " + short_number(scale) +
                                 " times as far as the mirror says: s is the mirror's mechanical "
                                 "angle (the beam turns twice that); check its unit and gain"};
}

/// Fills in the stripe points on the boards; their axis positions are returned.
std::vector<double> add_stripes(Examined& all, const Board& board) {
    const BoardColours colours(board);
    std::vector<double> positions;
    for (std::size_t i = 0; i < all.first.size(); ++i) {
        const Rigid3 pose = board_motion(all.channel, all.first_s[i]).inverse() * all.first[i];
        for (const StripePoint& point :
             stripe_points_on_board(*all.pulses[i], all.channel, pose, colours, kStripePoints)) {
            const Rigid3 at_s = board_motion(all.channel, point.s) * pose;
            const Eigen::Vector3d ray = ray_through(all.channel.camera, point.pixel);
            const Eigen::Vector3d normal = at_s.rotation.col(2);
            all.seen.stripe_in_camera.push_back(ray *
                                                (normal.dot(at_s.translation) / normal.dot(ray)));
            positions.push_back(point.s);
        }
    }
    return positions;
}

}  // namespace

std::vector<DegeneracyFinding> find_degeneracies(const std::vector<CornerView>& views,
                                                 const Board& board, const ScannerModel& nominal) {
    constexpr double kLengthSigmaMm = ScannerCalibrationOptions{}.nominal_length_sigma_mm;
    Examined all = examine(views, board, nominal);
    if (all.first.empty()) return {};
    if (auto found = judge_count(all)) return {*found};
    if (auto found = judge_moved_scale(all, board)) return {*found};
    ScannerModel started = nominal;
    started.channels = {all.channel};
    if (all.axis.from_views)
        if (auto found = find_contradictions(started, nominal, kLengthSigmaMm); !found.empty())
            return found;
    const std::vector<double> positions = add_stripes(all, board);
    std::vector<DegeneracyFinding> findings;
    if (all.channel.axis.kind == MachineKind::swept)
        if (auto found = judge_mirror(all.channel, all.seen.stripe_in_camera, positions)) {
            if (found->prevents) return {*found};
            findings.push_back(*found);
        }
    const CameraModel& camera = all.channel.camera;
    for (auto& found : judge_coverage(all.seen, all.channel.axis.kind, camera.width, camera.height))
        findings.push_back(std::move(found));
    return findings;
}

}  // namespace stria
