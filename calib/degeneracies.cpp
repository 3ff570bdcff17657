#include "calib/degeneracies.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>

#include "firmware/core/angle.h"
#include "host/core/short_number.h"

namespace stria {
namespace {

constexpr double kLeastTiltRad = 15 * kDegree;  ///< between the farthest normals
constexpr double kFacingRad = 12 * kDegree;     ///< from the camera's axis: not tilted
constexpr double kLeastDepthShare = 0.15;       ///< of the nearest stripe's depth
constexpr double kLeastImageShare = 0.6;        ///< of width and of height
constexpr double kLeastArcRad = 60 * kDegree;
constexpr double kLeastTravelShare = 0.04;  ///< of the distance
constexpr double kOneLine = 0.05;           ///< second over first spread of the stripes
constexpr double kDrawingSigmas = 4;

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// Standard deviations of points along their principal directions, largest first.
Eigen::Vector3d spreads(const std::vector<Eigen::Vector3d>& points) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& p : points) mean += p / static_cast<double>(points.size());
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const auto& p : points)
        scatter += (p - mean) * (p - mean).transpose() / static_cast<double>(points.size());
    return scatter.jacobiSvd().singularValues().cwiseSqrt();
}

void judge_tilt(const CalibrationCoverage& seen, std::vector<DegeneracyFinding>& findings) {
    double widest = 0, from_axis = 0;
    const auto& normals = seen.board_normals;
    for (std::size_t i = 0; i < normals.size(); ++i) {
        from_axis = std::max(from_axis, angle_between(normals[i], Eigen::Vector3d::UnitZ()));
        for (std::size_t j = i + 1; j < normals.size(); ++j)
            widest = std::max(widest, angle_between(normals[i], normals[j]));
    }
    if (normals.empty()) return;
    if (from_axis < kFacingRad)
        findings.push_back(
            {Degeneracy::no_tilt, false,
             "no board is tilted (at most " + short_number(from_axis / kDegree, 3) +
                 " deg from facing the camera), so the boards are nearly parallel to each other: "
                 "focal length and distance cannot be told apart; tilt the board 20 to 40 deg to "
                 "the left, right, back and forward"});
    else if (widest < kLeastTiltRad)
        findings.push_back({Degeneracy::parallel_boards, false,
                            "the boards are nearly parallel to each other (at most " +
                                short_number(widest / kDegree, 3) +
                                " deg apart): focal length and depth are weak; tilt the board 20 "
                                "to 40 deg to different sides"});
}

void judge_stripes(const CalibrationCoverage& seen, MachineKind kind,
                   std::vector<DegeneracyFinding>& findings) {
    if (seen.stripe_in_camera.size() < 3) return;
    const Eigen::Vector3d spread = spreads(seen.stripe_in_camera);
    if (kind != MachineKind::swept && spread[1] < kOneLine * spread[0]) {
        findings.push_back(
            {Degeneracy::one_stripe_line, false,
             "the stripes of all views lie nearly on one line of the laser's sheet, about which it "
             "can still turn: place the board at different depths"});
        return;  // one line is also one depth
    }
    std::vector<double> depths;
    for (const auto& p : seen.stripe_in_camera) depths.push_back(p.z());
    const double near = quantile(depths, 0.02), far = quantile(depths, 0.98);
    if (far - near < kLeastDepthShare * near)
        findings.push_back({Degeneracy::one_depth, false,
                            "the stripe was seen between " + short_number(near, 3) + " and " +
                                short_number(far, 3) +
                                " mm from the camera only: place the board nearer and farther, "
                                "over the whole depth you will scan"});
}

void judge_image(const CalibrationCoverage& seen, int image_width, int image_height,
                 std::vector<DegeneracyFinding>& findings) {
    std::vector<double> us, vs;
    for (const auto& p : seen.corner_pixels) {
        us.push_back(p.x());
        vs.push_back(p.y());
    }
    const double wide = (quantile(us, 1) - quantile(us, 0)) / image_width;
    const double high = (quantile(vs, 1) - quantile(vs, 0)) / image_height;
    if (!us.empty() && (wide < kLeastImageShare || high < kLeastImageShare))
        findings.push_back({Degeneracy::centre_only, false,
                            "the board covered " + short_number(100 * wide, 2) +
                                " % of the image's width and " + short_number(100 * high, 2) +
                                " % of its height: lens distortion is a guess outside; bring the "
                                "board to the image's sides and corners"});
}

void judge_axis(const CalibrationCoverage& seen, MachineKind kind,
                std::vector<DegeneracyFinding>& findings) {
    const double travel = quantile(seen.picture_s, 1) - quantile(seen.picture_s, 0);
    if (kind == MachineKind::swept || seen.picture_s.empty()) return;
    double distance = 0;
    for (const auto& p : seen.stripe_in_camera)
        distance += p.z() / static_cast<double>(seen.stripe_in_camera.size());
    if (!(travel > 1e-6))
        findings.push_back(
            {Degeneracy::axis_unobservable, false,
             "every picture was taken at one position of the axis, so its direction and place stay "
             "as drawn: take pictures at 5 positions of the travel (off_frames = 5)"});
    else if (kind == MachineKind::turntable && travel < kLeastArcRad)
        findings.push_back({Degeneracy::short_arc, false,
                            "the board was pictured over " + short_number(travel / kDegree, 3) +
                                " deg of the table's turn only: its centre is weak below 60 deg; "
                                "take pictures at more positions (off_frames)"});
    else if (kind == MachineKind::rail && travel < kLeastTravelShare * distance)
        findings.push_back({Degeneracy::short_travel, false,
                            "the board was pictured over " + short_number(travel, 3) +
                                " mm of the rail only: its direction is weak; take pictures at "
                                "both ends (off_frames)"});
}

/// Distance of the camera from the machine's axis of turn, mm; 0 for a rail.
double axis_distance_mm(const Channel& channel) {
    if (channel.axis.kind == MachineKind::swept) {
        const Eigen::Vector3d& point = channel.axis.mirror.point;
        return (point - channel.axis.mirror.direction * channel.axis.mirror.direction.dot(point))
            .norm();
    }
    if (channel.axis.kind == MachineKind::rail) return 0;
    const Rigid3 camera_from_table = channel.axis.turntable.table_from_camera.inverse();
    return camera_from_table.translation.cross(camera_from_table.rotation.col(2)).norm();
}

}  // namespace

const char* name_of(Degeneracy kind) {
    switch (kind) {
        case Degeneracy::one_view:
            return "one view";
        case Degeneracy::too_few_views:
            return "too few views";
        case Degeneracy::same_view:
            return "same view";
        case Degeneracy::no_tilt:
            return "no tilt";
        case Degeneracy::parallel_boards:
            return "parallel boards";
        case Degeneracy::one_depth:
            return "one depth";
        case Degeneracy::centre_only:
            return "centre only";
        case Degeneracy::one_stripe_line:
            return "one stripe line";
        case Degeneracy::axis_unobservable:
            return "axis unobservable";
        case Degeneracy::short_arc:
            return "short arc";
        case Degeneracy::short_travel:
            return "short travel";
        case Degeneracy::square_size:
            return "square size";
        case Degeneracy::axis_constant:
            return "axis constant";
        case Degeneracy::narrow_sweep:
            return "narrow sweep";
    }
    return "";
}

std::vector<DegeneracyFinding> judge_coverage(const CalibrationCoverage& seen, MachineKind kind,
                                              int image_width, int image_height) {
    std::vector<DegeneracyFinding> findings;
    judge_tilt(seen, findings);
    judge_stripes(seen, kind, findings);
    judge_image(seen, image_width, image_height, findings);
    judge_axis(seen, kind, findings);
    return findings;
}

std::vector<DegeneracyFinding> find_contradictions(const ScannerModel& solved,
                                                   const ScannerModel& nominal,
                                                   double nominal_length_sigma_mm) {
    const double found = axis_distance_mm(solved.channels.front());
    const double drawn = axis_distance_mm(nominal.channels.front());
    if (!(std::abs(found - drawn) > kDrawingSigmas * nominal_length_sigma_mm)) return {};
    return {{Degeneracy::square_size, true,
             "the axis was found " + short_number(found, 4) +
                 " mm from the camera, the drawing says " + short_number(drawn, 4) +
                 " mm: the board's square size is wrong (all lengths " +
                 short_number(found / drawn, 4) +
                 " times the drawing's), or the drawing is; measure the "
                 "printed squares with a ruler"}};
}

}  // namespace stria
