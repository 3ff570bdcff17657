#include "calib/sheet_calibration.h"

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "calib/pose_covariance.h"
#include "calib/sheet_fit.h"
#include "host/core/errors.h"
#include "host/core/short_number.h"

namespace stria {
namespace {

constexpr double kWorstPoseRmsPx = 3;     // above, these are not this board's corners
constexpr double kLeastSpread = 0.01;     // of the distance, across the mean line
constexpr double kLoosestTurnRad = 0.02;  // standard deviation
constexpr double kLeastAngleRad = 0.02;   // between rays and sheet

/// A view that can be used.
struct Crossing {
    std::size_t view = 0;
    Rigid3 camera_from_board;
    Matrix6d unit_covariance;  // of the pose, for corners of 1 px
    StripeLine line;

    Eigen::Vector3d in_camera(const Eigen::Vector2d& on_board) const {
        return camera_from_board * Eigen::Vector3d(on_board.x(), on_board.y(), 0);
    }
};

StripeLine clearest_line(const std::vector<std::vector<StripePeak>>& peaks,
                         const CameraModel& camera, const Rigid3& pose,
                         const BoardColours& colours) {
    StripeLine best;
    best.refusal = "stripe not crossing: no stripe peak in the picture";
    for (const auto& alternative : peaks) {
        StripeLine line = stripe_line_on_board(alternative, camera, pose, colours);
        const bool better = best.refusal.empty() ? line.points.size() > best.points.size()
                                                 : line.refusal.empty() || !alternative.empty();
        if (better && (line.refusal.empty() || !best.refusal.empty())) best = std::move(line);
    }
    return best;
}

std::optional<Crossing> crossing_of(const SheetView& view, const Board& board,
                                    const CameraModel& camera, const BoardColours& colours,
                                    std::string& why) {
    const auto pose = board_pose(camera, view.corners, board);
    if (!pose) {
        why = "too few corners: they do not determine where the board is";
        return std::nullopt;
    }
    const double rms = view_rms_px(camera, *pose, view.corners, board);
    if (!(rms <= kWorstPoseRmsPx)) {
        why = "wrong board or camera: the corners lie " + short_number(rms, 3) +
              " px (rms) from where the camera would see those of " + to_string(board);
        return std::nullopt;
    }
    Crossing crossing;
    crossing.camera_from_board = *pose;
    crossing.unit_covariance = pose_covariance(camera, *pose, view.corners, board);
    crossing.line = clearest_line(view.peaks, camera, *pose, colours);
    why = crossing.line.refusal;
    if (!why.empty()) return std::nullopt;
    return crossing;
}

/// Standard deviation of a corner's coordinate, the poses' freedom counted.
double corner_sigma_px(const std::vector<Crossing>& crossings, const std::vector<SheetView>& views,
                       const Board& board, const CameraModel& camera) {
    double sum = 0, freedom = 0;
    for (const Crossing& c : crossings) {
        const CameraView& corners = views[c.view].corners;
        const double points = static_cast<double>(corners.ids.size());
        sum += points * std::pow(view_rms_px(camera, c.camera_from_board, corners, board), 2);
        freedom += 2 * points - 6;
    }
    return freedom > 0 ? std::sqrt(sum / freedom) : 0;
}

SheetLine sheet_line(const Crossing& c, double corner_sigma) {
    const Eigen::Vector2d& n = c.line.normal;
    return {.ends = {c.in_camera(c.line.ends[0]), c.in_camera(c.line.ends[1])},
            .across = c.camera_from_board.rotation * Eigen::Vector3d(n.x(), n.y(), 0),
            .line_covariance = c.line.covariance,
            .pose_covariance = corner_sigma * corner_sigma * c.unit_covariance};
}

double sum_of_squares(const Crossing& c, const SheetFit& sheet) {
    double sum = 0;
    for (const Eigen::Vector2d& p : c.line.points)
        sum += std::pow(sheet.normal.dot(c.in_camera(p)) - sheet.offset_mm, 2);
    return sum;
}

double turn_sigma(const Eigen::Matrix4d& covariance) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance.topLeftCorner<3, 3>());
    return std::sqrt(std::max(0.0, eigen.eigenvalues()[2]));
}

[[noreturn]] void refuse_too_few(const std::vector<SheetViewResult>& views, std::size_t usable) {
    std::string reasons;
    for (const SheetViewResult& view : views)
        if (!view.rejected.empty()) reasons += "\n  " + view.name + ": " + view.rejected;
    throw Error(
        "a sheet needs the stripe over at least 2 placements of the board (3 to check it), "
        "found " +
        std::to_string(usable) +
        ": a stripe on one board is one line, and the sheet can turn about it" + reasons);
}

void refuse_degenerate(const std::vector<SheetLine>& lines, const SheetFit& sheet) {
    double distance = 0, nearest = 1e9;
    for (const SheetLine& line : lines)
        for (const Eigen::Vector3d& end : line.ends) {
            distance += end.norm() / (2.0 * static_cast<double>(lines.size()));
            nearest = std::min(nearest, sheet.offset_mm / end.norm());
        }
    const double spread = spread_across_mm(lines), turn = turn_sigma(sheet.covariance);
    if (spread < kLeastSpread * distance || turn > kLoosestTurnRad)
        throw Error("the stripes of all " + std::to_string(lines.size()) +
                    " views lie nearly on one line (spread " + short_number(spread, 3) +
                    " mm across it at " + short_number(distance, 3) +
                    " mm), about which the sheet can turn: hold the board nearer and farther, over "
                    "a third of the distance or more");
    if (std::asin(std::min(1.0, nearest)) < kLeastAngleRad)
        throw Error("the sheet passes " + short_number(sheet.offset_mm, 3) +
                    " mm from the camera's centre: the camera looks along it and sees the same "
                    "stripe at every distance; move the laser away from the camera");
}

void measure_left_out(SheetCalibration& result, const std::vector<Crossing>& crossings,
                      const std::vector<SheetLine>& lines) {
    double sum = 0;
    for (std::size_t out = 0; out < lines.size(); ++out) {
        std::vector<SheetLine> others = lines;
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(out));
        const double squares = sum_of_squares(crossings[out], fit_sheet(others, false));
        auto& view = result.views[crossings[out].view];
        view.left_out_rms_mm = std::sqrt(squares / view.points);
        sum += squares;
    }
    result.left_out_rms_mm = std::sqrt(sum / result.points_used);
}

/// Drops the crossings whose line is off the sheet of all others, and says so.
void drop_far_off(std::vector<Crossing>& crossings, std::vector<SheetLine>& lines,
                  const SheetFit& sheet, std::vector<SheetViewResult>& views) {
    for (std::size_t i = lines.size(); i-- > 0;) {
        if (sheet.used[i]) continue;
        const auto& points = crossings[i].line.points;
        const double rms =
            std::sqrt(sum_of_squares(crossings[i], sheet) / static_cast<double>(points.size()));
        views[crossings[i].view].rejected =
            "its stripe lies " + short_number(rms, 3) +
            " mm from the sheet of the other views: did board, camera or laser move?";
        crossings.erase(crossings.begin() + static_cast<std::ptrdiff_t>(i));
        lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(i));
    }
}

}  // namespace

SheetCalibration calibrate_sheet(const std::vector<SheetView>& views, const Board& board,
                                 const CameraModel& camera) {
    if (const std::string why = validate(camera); !why.empty()) throw Error("camera: " + why);
    const BoardColours colours(board);
    SheetCalibration result;
    std::vector<Crossing> crossings;
    for (std::size_t i = 0; i < views.size(); ++i) {
        SheetViewResult& out = result.views.emplace_back();
        out.name = views[i].corners.name;
        auto crossing = crossing_of(views[i], board, camera, colours, out.rejected);
        if (!crossing) continue;
        crossing->view = i;
        crossings.push_back(std::move(*crossing));
    }
    if (crossings.size() < 2) refuse_too_few(result.views, crossings.size());
    result.corner_sigma_px = corner_sigma_px(crossings, views, board, camera);
    std::vector<SheetLine> lines;
    for (const Crossing& c : crossings) lines.push_back(sheet_line(c, result.corner_sigma_px));
    const SheetFit sheet = fit_sheet(lines);
    drop_far_off(crossings, lines, sheet, result.views);
    refuse_degenerate(lines, sheet);

    double sum = 0;
    for (const Crossing& c : crossings) {
        SheetViewResult& out = result.views[c.view];
        const double squares = sum_of_squares(c, sheet);
        out.points = static_cast<int>(c.line.points.size());
        out.rms_mm = std::sqrt(squares / out.points);
        for (const Eigen::Vector2d& p : c.line.points)
            if (const auto pixel = project(camera, c.in_camera(p))) out.pixels.push_back(*pixel);
        result.points_used += out.points;
        sum += squares;
    }
    result.normal = sheet.normal;
    result.offset_mm = sheet.offset_mm;
    result.covariance = sheet.covariance;
    result.turn_sigma_rad = turn_sigma(sheet.covariance);
    result.chi_square = sheet.chi_square;
    result.views_used = static_cast<int>(crossings.size());
    result.rms_mm = std::sqrt(sum / result.points_used);
    if (lines.size() >= 3) measure_left_out(result, crossings, lines);
    return result;
}

}  // namespace stria
