#include "calib/predicted_sigma.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace stria {
namespace {

/// Derivative of all points (3 rows a point) by one parameter, by central differences of `step`;
/// empty if a point is lost.
Eigen::VectorXd points_moved(const ScannerModel& model, const std::vector<VolumeSample>& samples,
                             Eigen::Index parameter, double step) {
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(model.covariance.rows());
    delta[parameter] = step;
    const Channel after = perturbed(model, delta).channels[0];
    const Channel before = perturbed(model, -delta).channels[0];
    Eigen::VectorXd moved(3 * static_cast<Eigen::Index>(samples.size()));
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const auto a = triangulate(after, samples[i].pixel, samples[i].s);
        const auto b = triangulate(before, samples[i].pixel, samples[i].s);
        const auto row = 3 * static_cast<Eigen::Index>(i);
        moved.segment<3>(row).setZero();
        if (a && b) moved.segment<3>(row) = (a->point_in_scan - b->point_in_scan) / (2 * step);
    }
    return moved;
}

/// Columns: how the points move under small rotations and shifts.
Eigen::MatrixXd rigid_motions(const std::vector<Eigen::Vector3d>& points) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const auto& p : points) middle += p / static_cast<double>(points.size());
    Eigen::MatrixXd motions(3 * static_cast<Eigen::Index>(points.size()), 6);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3d p = points[i] - middle;
        const auto row = 3 * static_cast<Eigen::Index>(i);
        for (int k = 0; k < 3; ++k) motions.block<3, 1>(row, k) = Eigen::Vector3d::Unit(k).cross(p);
        motions.block<3, 3>(row, 3).setIdentity();
    }
    return motions;
}

}  // namespace

PredictedSigma predict_sigma(const ScannerModel& model, const std::vector<VolumeSample>& samples) {
    std::vector<VolumeSample> kept;
    std::vector<Eigen::Vector3d> points;
    for (const VolumeSample& sample : samples)
        if (const auto spot = triangulate(model.channels[0], sample.pixel, sample.s)) {
            kept.push_back(sample);
            points.push_back(spot->point_in_scan);
        }
    const Eigen::Index count = model.covariance.rows();
    if (kept.size() < 4 || count == 0) return {};

    Eigen::MatrixXd by_sigma = Eigen::MatrixXd::Zero(3 * Eigen::Index(kept.size()), count);
    Eigen::VectorXd sigma = model.covariance.diagonal().cwiseMax(0).cwiseSqrt();
    for (Eigen::Index i = 0; i < count; ++i)
        if (sigma[i] > 0)
            by_sigma.col(i) = sigma[i] * points_moved(model, kept, i, std::min(1e-4, sigma[i]));
    const Eigen::MatrixXd motions = rigid_motions(points);
    by_sigma -= motions * motions.householderQr().solve(by_sigma);

    // Correlation instead of covariance: of a parameter in units of its own sigma.
    const Eigen::VectorXd inverse = sigma.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
    const Eigen::MatrixXd correlation =
        inverse.asDiagonal() * model.covariance * inverse.asDiagonal();
    std::vector<double> lengths;
    double sum = 0;
    for (std::size_t i = 0; i < kept.size(); ++i) {
        const auto rows = by_sigma.middleRows<3>(3 * static_cast<Eigen::Index>(i));
        const double variance = (rows * correlation * rows.transpose()).trace();
        lengths.push_back(std::sqrt(std::max(0.0, variance)));
        sum += variance;
    }
    std::sort(lengths.begin(), lengths.end());
    PredictedSigma predicted;
    predicted.median_mm = lengths[lengths.size() / 2];
    predicted.p95_mm = lengths[lengths.size() * 95 / 100];
    predicted.rms_mm = std::sqrt(sum / static_cast<double>(kept.size()));

    // The combination of parameters that moves the points most, and its largest part.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> parts(correlation);
    const Eigen::MatrixXd root =
        parts.eigenvectors() * parts.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
    const Eigen::MatrixXd effect = by_sigma * root;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(
        Eigen::MatrixXd(effect.transpose() * effect));
    const Eigen::VectorXd worst = root * modes.eigenvectors().col(count - 1);
    Eigen::Index largest = 0;
    worst.cwiseAbs().maxCoeff(&largest);
    predicted.weakest = parameter_names(model)[static_cast<std::size_t>(largest)];
    return predicted;
}

}  // namespace stria
