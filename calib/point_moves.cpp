#include "calib/point_moves.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <cmath>

namespace stria {
namespace {

constexpr double kModeStep = 0.05;  ///< standard deviations

/// Points of the samples, and which there are.
std::vector<Eigen::Vector3d> points_of(const Channel& channel,
                                       const std::vector<VolumeSample>& samples,
                                       std::vector<std::uint8_t>& known) {
    std::vector<Eigen::Vector3d> points;
    known.assign(samples.size(), 0);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const auto spot = triangulate(channel, samples[i].pixel, samples[i].s);
        known[i] = spot.has_value();
        points.push_back(spot ? spot->point_in_scan : Eigen::Vector3d::Zero());
    }
    return points;
}

/// b - a where both are known, else zero.
Eigen::VectorXd differences(const std::vector<Eigen::Vector3d>& a,
                            const std::vector<std::uint8_t>& has_a,
                            const std::vector<Eigen::Vector3d>& b,
                            const std::vector<std::uint8_t>& has_b) {
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(a.size()));
    for (std::size_t i = 0; i < a.size(); ++i)
        if (has_a[i] && has_b[i]) moved.segment<3>(3 * Eigen::Index(i)) = b[i] - a[i];
    return moved;
}

}  // namespace

std::vector<VolumeSample> field_samples(const Channel& channel, double from, double to,
                                        double near_mm, double far_mm, int positions) {
    constexpr int kColumns = 6, kRows = 5;
    std::vector<VolumeSample> samples;
    for (int row = 0; row < kRows; ++row)
        for (int column = 0; column < kColumns; ++column)
            for (int k = 0; k < positions; ++k) {
                const Eigen::Vector2d pixel(channel.camera.width * (column + 0.5) / kColumns,
                                            channel.camera.height * (row + 0.5) / kRows);
                const double s = from + (to - from) * k / (positions - 1);
                const auto spot = triangulate(channel, pixel, s);
                if (!spot) continue;
                const Eigen::Vector3d in_camera =
                    scan_from_camera(channel, s).inverse() * spot->point_in_scan;
                if (in_camera.z() >= near_mm && in_camera.z() <= far_mm)
                    samples.push_back({pixel, s});
            }
    return samples;
}

Eigen::Vector2d working_distance_mm(const Channel& channel, double from, double to) {
    const double s = 0.5 * (from + to);
    const auto spot = triangulate(channel, {channel.camera.cx, channel.camera.cy}, s);
    if (!spot) return Eigen::Vector2d::Zero();
    const double z = (scan_from_camera(channel, s).inverse() * spot->point_in_scan).z();
    return {0.8 * z, 1.25 * z};
}

void remove_rigid_motion(const std::vector<Eigen::Vector3d>& points, Eigen::MatrixXd& moves) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const auto& p : points) middle += p / static_cast<double>(points.size());
    Eigen::MatrixXd motions(moves.rows(), 6);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto row = 3 * static_cast<Eigen::Index>(i);
        for (int k = 0; k < 3; ++k)
            motions.block<3, 1>(row, k) = Eigen::Vector3d::Unit(k).cross(points[i] - middle);
        motions.block<3, 3>(row, 3).setIdentity();
    }
    moves -= motions * motions.householderQr().solve(moves);
}

Eigen::MatrixXd point_moves(const ScannerModel& model, const Eigen::MatrixXd& modes,
                            const std::vector<VolumeSample>& samples) {
    std::vector<std::uint8_t> known, has_a, has_b;
    const auto points = points_of(model.channels.front(), samples, known);
    Eigen::MatrixXd moves(3 * static_cast<Eigen::Index>(samples.size()), modes.cols());
    for (Eigen::Index k = 0; k < modes.cols(); ++k) {
        const Eigen::VectorXd step = kModeStep * modes.col(k);
        const auto a = points_of(perturbed(model, -step).channels.front(), samples, has_a);
        const auto b = points_of(perturbed(model, step).channels.front(), samples, has_b);
        moves.col(k) = differences(a, has_a, b, has_b) / (2 * kModeStep);
    }
    if (samples.size() >= 4) remove_rigid_motion(points, moves);
    return moves;
}

Eigen::VectorXd point_differences(const ScannerModel& a, const ScannerModel& b,
                                  const std::vector<VolumeSample>& samples) {
    std::vector<std::uint8_t> has_a, has_b;
    const auto points = points_of(a.channels.front(), samples, has_a);
    const auto others = points_of(b.channels.front(), samples, has_b);
    Eigen::MatrixXd moved = differences(points, has_a, others, has_b);
    if (samples.size() >= 4) remove_rigid_motion(points, moved);
    return moved;
}

}  // namespace stria
