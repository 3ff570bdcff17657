#include <algorithm>
#include <cmath>
#include <sstream>

#include "calib/coach.h"
#include "firmware/core/angle.h"

namespace stria {
namespace {

constexpr double kFacingRad = 0.08;  ///< less is no tilt worth a word

std::string rounded(double value, double step) {
    std::ostringstream out;
    out << step * std::round(value / step);
    return out.str();
}

/// "to the left and high", "in the middle".
std::string place_in_image(const CameraModel& camera, const Eigen::Vector3d& middle) {
    const Eigen::Vector2d pixel =
        project(camera, middle).value_or(Eigen::Vector2d(camera.cx, camera.cy));
    const double u = pixel.x() / camera.width, v = pixel.y() / camera.height;
    const char* aside = u < 0.4 ? "to the left" : u > 0.6 ? "to the right" : "";
    const char* height = v < 0.4 ? "high" : v > 0.6 ? "low" : "";
    if (!*aside && !*height) return "in the middle of the image";
    if (!*aside) return std::string(height) + " in the image";
    if (!*height) return std::string(aside) + " of the image";
    return std::string(aside) + " of the image and " + height;
}

/// "facing the camera", "its right side 35 deg farther".
std::string tilt(const Eigen::Vector3d& normal) {
    // normal . p = d: z grows along x by -nx / nz and along y (down) by -ny / nz.
    const double right = std::atan2(-normal.x(), normal.z());
    const double lower = std::atan2(-normal.y(), normal.z());
    std::string text;
    const auto add = [&](double angle, const char* positive, const char* negative) {
        if (std::abs(angle) < kFacingRad) return;
        text += (text.empty() ? "its " : " and its ");
        text += angle > 0 ? positive : negative;
        text += " " + rounded(std::abs(angle) / kDegree, 5) + " deg farther away";
    };
    add(right, "right side", "left side");
    add(lower, "lower edge", "upper edge");
    return text.empty() ? "facing the camera" : text;
}

}  // namespace

std::string describe_placement(const CameraModel& camera, const Board& board,
                               const Rigid3& camera_from_board) {
    const auto points = board_points(board);
    const Eigen::Vector3d middle = camera_from_board * (0.5 * (points.front() + points.back()));
    const Eigen::Vector3d along = camera_from_board.rotation.col(0);
    const double roll = std::abs(std::atan2(along.y(), along.x()));
    const bool upright = roll > 0.7853981633974483 && roll < 2.356194490192345;
    return rounded(middle.z(), 10) + " mm away, " + place_in_image(camera, middle) + ", " +
           tilt(camera_from_board.rotation.col(2)) +
           (upright ? ", turned by a quarter in its plane" : "");
}

std::string in_words(const std::string& parameter) {
    static const std::pair<const char*, const char*> kWords[] = {
        {"camera.f", "focal length"},
        {"camera.c", "centre of the image"},
        {"camera.k", "lens distortion"},
        {"camera.p", "lens distortion"},
        {"sheet.bow", "bow of the laser's sheet"},
        {"sheet.", "place of the laser's sheet"},
        {"mirror.g", "angle law of the mirror"},
        {"mirror.", "place of the mirror"},
        {"rail.", "direction of the rail"},
        {"table.", "axis of the table"},
        {"axis.delay", "delay of the axis clock"},
    };
    for (const auto& [part, words] : kWords)
        if (parameter.find(part) != std::string::npos) return words;
    return parameter;
}

}  // namespace stria
