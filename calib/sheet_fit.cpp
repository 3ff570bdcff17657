#include "calib/sheet_fit.h"

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "firmware/core/median.h"
#include "host/geometry/fit.h"

namespace stria {
namespace {

constexpr double kHuber = 1.345, kFarOff = 5;  // standard deviations
constexpr double kMedianOfTwo = 1.386;         // median of chi-square with 2 degrees of freedom
constexpr double kExactMm = 1e-6;              // lines are never known better: keeps weights finite

Eigen::Vector2d distances(const SheetFit& sheet, const SheetLine& line) {
    return {sheet.normal.dot(line.ends[0]) - sheet.offset_mm,
            sheet.normal.dot(line.ends[1]) - sheet.offset_mm};
}

double chi_square(const SheetFit& sheet, const SheetLine& line) {
    const Eigen::Vector2d off = distances(sheet, line);
    return off.dot(line.covariance_along(sheet.normal).ldlt().solve(off));
}

/// (normal, offset) changed by d = (turns about two axes across the normal, offset).
using Tangent = Eigen::Matrix<double, 4, 3>;
Tangent tangent_of(const Eigen::Vector3d& normal) {
    const Eigen::Vector3d t = normal.unitOrthogonal();
    Tangent tangent = Tangent::Zero();
    tangent.topLeftCorner<3, 1>() = t;
    tangent.block<3, 1>(0, 1) = normal.cross(t);
    tangent(3, 2) = 1;
    return tangent;
}

void set(SheetFit& sheet, const Eigen::Vector3d& normal, double offset_mm) {
    const double length = offset_mm < 0 ? -normal.norm() : normal.norm();
    sheet.normal = normal / length;
    sheet.offset_mm = offset_mm / length;
}

/// A Gauss-Newton step; returns the information of the tangent's parameters.
Eigen::Matrix3d improve(SheetFit& sheet, const std::vector<SheetLine>& lines,
                        const std::vector<double>& weights) {
    const Tangent tangent = tangent_of(sheet.normal);
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (weights[i] == 0) continue;
        Eigen::Matrix<double, 2, 4> by_sheet;
        by_sheet << lines[i].ends[0].transpose(), -1, lines[i].ends[1].transpose(), -1;
        const Eigen::Matrix<double, 2, 3> rows = by_sheet * tangent;
        const auto white = lines[i].covariance_along(sheet.normal).ldlt();
        information += weights[i] * rows.transpose() * white.solve(rows);
        gradient += weights[i] * rows.transpose() * white.solve(distances(sheet, lines[i]));
    }
    const Eigen::Vector4d change =
        tangent * information.completeOrthogonalDecomposition().solve(-gradient);
    if (change.allFinite())
        set(sheet, sheet.normal + change.head<3>(), sheet.offset_mm + change[3]);
    return information;
}

/// What the information leaves open stays finite, and huge.
Eigen::Matrix3d inverse_of(const Eigen::Matrix3d& information) {
    const Eigen::Vector3d scale =
        information.diagonal().cwiseSqrt().cwiseMax(1e-150).cwiseInverse();
    const Eigen::Matrix3d scaled = scale.asDiagonal() * information * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scaled);
    const Eigen::Vector3d strength = eigen.eigenvalues().cwiseMax(1e-15);
    return scale.asDiagonal() * eigen.eigenvectors() * strength.cwiseInverse().asDiagonal() *
           eigen.eigenvectors().transpose() * scale.asDiagonal();
}

double median_distance(const SheetFit& sheet, const std::vector<SheetLine>& lines) {
    std::vector<double> off;
    for (const SheetLine& line : lines) off.push_back(distances(sheet, line).norm());
    return median(std::move(off));
}

SheetFit start_of(const std::vector<SheetLine>& lines) {
    SheetFit best;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < lines.size(); ++i)
        for (std::size_t j = i + 1; j < lines.size(); ++j) {
            const Eigen::Vector3d ends[] = {lines[i].ends[0], lines[i].ends[1], lines[j].ends[0],
                                            lines[j].ends[1]};
            const PlaneFit plane = fit_plane(ends);
            SheetFit sheet;
            set(sheet, plane.normal, plane.offset_mm);
            const double off = median_distance(sheet, lines);
            if (off < least) {
                least = off;
                best = sheet;
            }
        }
    return best;
}

double robust_scale(const SheetFit& sheet, const std::vector<SheetLine>& lines) {
    std::vector<double> all;
    for (const SheetLine& line : lines) all.push_back(chi_square(sheet, line));
    return std::max(1.0, std::sqrt(median(std::move(all)) / kMedianOfTwo));
}

}  // namespace

Eigen::Matrix2d SheetLine::covariance_along(const Eigen::Vector3d& sheet_normal) const {
    Eigen::Matrix<double, 2, 6> by_pose;  // n . (turn x end + shift)
    by_pose << ends[0].cross(sheet_normal).transpose(), sheet_normal.transpose(),
        ends[1].cross(sheet_normal).transpose(), sheet_normal.transpose();
    const double slant = sheet_normal.dot(across);
    return slant * slant * line_covariance + by_pose * pose_covariance * by_pose.transpose() +
           kExactMm * kExactMm * Eigen::Matrix2d::Identity();
}

SheetFit fit_sheet(const std::vector<SheetLine>& lines, bool reject_lines) {
    if (lines.size() < 2)
        throw std::invalid_argument("fit_sheet: " + std::to_string(lines.size()) +
                                    " lines, expected at least 2");
    SheetFit sheet = start_of(lines);
    sheet.used.assign(lines.size(), true);
    std::vector<double> weights(lines.size(), 1.0);
    for (int round = 0; round < 12; ++round) {
        const double limit = kHuber * robust_scale(sheet, lines);
        for (std::size_t i = 0; i < lines.size(); ++i)
            weights[i] = std::min(1.0, limit / std::sqrt(chi_square(sheet, lines[i]) / 2));
        improve(sheet, lines, weights);
    }
    const double limit = kFarOff * robust_scale(sheet, lines);
    std::size_t used = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const bool far = std::sqrt(chi_square(sheet, lines[i]) / 2) > limit;
        sheet.used[i] = !(far && reject_lines && lines.size() >= 4);
        weights[i] = sheet.used[i] ? 1.0 : 0.0;
        used += sheet.used[i];
    }
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    for (int round = 0; round < 6; ++round) information = improve(sheet, lines, weights);
    double sum = 0;
    for (std::size_t i = 0; i < lines.size(); ++i)
        if (sheet.used[i]) sum += chi_square(sheet, lines[i]);
    if (used > 2) sheet.chi_square = sum / (2.0 * static_cast<double>(used) - 3.0);
    const Tangent tangent = tangent_of(sheet.normal);
    const Eigen::Matrix4d covariance =
        std::max(1.0, sheet.chi_square) * tangent * inverse_of(information) * tangent.transpose();
    sheet.covariance = 0.5 * (covariance + covariance.transpose());
    return sheet;
}

double spread_across_mm(const std::vector<SheetLine>& lines) {
    std::vector<Eigen::Vector3d> ends;
    for (const SheetLine& line : lines) ends.insert(ends.end(), line.ends.begin(), line.ends.end());
    return fit_plane(ends).singular_values[1] / std::sqrt(static_cast<double>(ends.size()));
}

}  // namespace stria
