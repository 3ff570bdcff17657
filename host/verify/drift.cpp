#include "host/verify/drift.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

#include "host/core/errors.h"
#include "host/core/p_values.h"
#include "host/verify/flatness.h"
#include "host/verify/probing.h"

namespace stria {
namespace {

using Eigen::Vector3d;

/// How linear least squares takes figures from points: figures = weights x residuals.
struct Linear {
    Eigen::MatrixXd weights;  ///< figures x points
    const ScanPoints& points;
    const std::vector<Vector3d>& normals;
};

/// @param rows  one a point; not kept: zero
/// @param last  how many of the coefficients, from the end, are figures
Linear least_squares(const Eigen::MatrixXd& rows, Eigen::Index last, const ScanPoints& points,
                     const std::vector<Vector3d>& normals) {
    const Eigen::MatrixXd inverse =
        (rows.transpose() * rows).ldlt().solve(Eigen::MatrixXd::Identity(rows.cols(), rows.cols()));
    return {(inverse * rows.transpose()).bottomRows(last), points, normals};
}

Eigen::MatrixXd noise_of(const Linear& linear) {
    Eigen::VectorXd variance(linear.weights.cols());
    for (Eigen::Index i = 0; i < variance.size(); ++i) {
        const auto k = static_cast<std::size_t>(i);
        variance[i] = std::pow(random_along(linear.points.noise[k], linear.normals[k]), 2);
    }
    return linear.weights * variance.asDiagonal() * linear.weights.transpose();
}

Eigen::MatrixXd calibration_of(const Linear& linear) {
    const auto modes = static_cast<Eigen::Index>(linear.points.sensitivity_count);
    Eigen::MatrixXd by_mode(linear.weights.cols(), modes);
    for (Eigen::Index i = 0; i < by_mode.rows(); ++i) {
        const auto k = static_cast<std::size_t>(i);
        const double along = linear.points.noise[k].direction.cast<double>().dot(linear.normals[k]);
        for (Eigen::Index mode = 0; mode < modes; ++mode)
            by_mode(i, mode) =
                along * static_cast<double>(
                            linear.points.sensitivity[static_cast<std::size_t>(i * modes + mode)]);
    }
    const Eigen::MatrixXd figures = linear.weights * by_mode;
    return figures * figures.transpose();
}

void need_calibration(const ScanPoints& scan) {
    if (!scan.has_noise() || scan.sensitivity_count == 0)
        throw Error(
            "the scan does not state what its calibration expects of itself, so that drift cannot "
            "be told from it: expected a scan triangulated with a scanner.toml that has a "
            "covariance");
}

}  // namespace

std::vector<ShapeFigure> shape_figures(const std::string& kind) {
    if (kind == "sphere") return {{"diameter", "diameter of the sphere", 0}};
    return {{"bend_along", "bend of the plane along its longer side", 0},
            {"bend_across", "bend of the plane along its shorter side", 0},
            {"twist", "twist of the plane", 0}};
}

ShapeCheck check_sphere(const ScanPoints& scan, const Artefact& artefact,
                        const SphereRegionOptions& options, std::mt19937& rng) {
    need_calibration(scan);
    const ProbingPosition position = probe_sphere(scan, artefact, options, rng);
    const MeasuredSphere& sphere = position.sphere;
    const auto count = static_cast<Eigen::Index>(sphere.points.positions.size());
    std::vector<Vector3d> normals;
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(count, 4);
    for (Eigen::Index i = 0; i < count; ++i) {
        const auto k = static_cast<std::size_t>(i);
        normals.push_back((sphere.points.positions[k] - sphere.centre).normalized());
        if (sphere.form.kept[k] != 0) rows.row(i) << normals.back().transpose(), 0.5;
    }
    const Linear linear = least_squares(rows, 1, sphere.points, normals);
    ShapeCheck check;
    check.kind = "sphere";
    check.figures = shape_figures(check.kind);
    check.figures[0].off_mm = position.size_mm;
    check.noise = noise_of(linear);
    check.calibration = calibration_of(linear);
    const double sigma = at_temperature(artefact, artefact.diameters.at(0)).expanded_mm / 2;
    check.artefact = Eigen::MatrixXd::Constant(1, 1, sigma * sigma);
    return check;
}

ShapeCheck check_plane(const ScanPoints& scan, const Artefact& artefact, std::mt19937& rng) {
    need_calibration(scan);
    PlaneSearch search;
    search.size_mm = {artefact.size_mm[0], artefact.size_mm[1]};
    search.margin_mm = artefact.margin_mm;
    const MeasuredPlane plane = measure_plane(scan, search, rng);
    const auto count = static_cast<Eigen::Index>(plane.points.positions.size());
    const Vector3d across = plane.normal.cross(plane.along);
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(count, 6);
    Eigen::VectorXd heights = Eigen::VectorXd::Zero(count);
    for (Eigen::Index i = 0; i < count; ++i) {
        const auto k = static_cast<std::size_t>(i);
        if (plane.form.kept[k] == 0) continue;
        const Vector3d from = plane.points.positions[k] - plane.centre;
        const double a = from.dot(plane.along) / (plane.used_mm.x() / 2);
        const double b = from.dot(across) / (plane.used_mm.y() / 2);
        rows.row(i) << 1, a, b, a * a, b * b, a * b;
        heights[i] = from.dot(plane.normal);
    }
    const std::vector<Vector3d> normals(static_cast<std::size_t>(count), plane.normal);
    const Linear linear = least_squares(rows, 3, plane.points, normals);
    const Eigen::Vector3d off = linear.weights * heights;
    ShapeCheck check;
    check.kind = "plane";
    check.figures = shape_figures(check.kind);
    for (std::size_t i = 0; i < 3; ++i) check.figures[i].off_mm = off[static_cast<Eigen::Index>(i)];
    check.noise = noise_of(linear);
    check.calibration = calibration_of(linear);
    check.artefact = artefact.form_mm * artefact.form_mm / 12 * Eigen::Matrix3d::Identity();
    return check;
}

Drift judge_drift(const ShapeCheck& now, const ShapeCheck* reference) {
    const auto count = static_cast<Eigen::Index>(now.figures.size());
    Eigen::MatrixXd covariance = now.noise + now.calibration;
    if (reference)
        covariance += reference->noise + reference->calibration;
    else
        covariance += now.artefact;
    Eigen::VectorXd off(count);
    Drift drift;
    for (Eigen::Index i = 0; i < count; ++i) {
        const auto k = static_cast<std::size_t>(i);
        off[i] = now.figures[k].off_mm - (reference ? reference->figures.at(k).off_mm : 0);
        drift.off_mm.push_back(off[i]);
        drift.expected_mm.push_back(std::sqrt(covariance(i, i)));
    }
    drift.p_value =
        chi_square_tail(off.dot(covariance.ldlt().solve(off)), static_cast<double>(count));
    return drift;
}

}  // namespace stria
