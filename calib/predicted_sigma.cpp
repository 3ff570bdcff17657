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
    const std::vector<Channel> after = perturbed(model, delta).channels;
    const std::vector<Channel> before = perturbed(model, -delta).channels;
    Eigen::VectorXd moved(3 * static_cast<Eigen::Index>(samples.size()));
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const VolumeSample& sample = samples[i];
        const auto a = triangulate(after[sample.channel], sample.pixel, sample.s);
        const auto b = triangulate(before[sample.channel], sample.pixel, sample.s);
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

/// How the points of the samples that triangulate depend on the parameters.
struct PointResponse {
    std::vector<std::size_t> kept;  ///< samples
    Eigen::MatrixXd by_sigma;       ///< 3 rows a kept sample, mm per sigma of each parameter
    Eigen::MatrixXd correlation;    ///< of the parameters
};

PointResponse respond(const ScannerModel& model, const std::vector<VolumeSample>& samples) {
    PointResponse response;
    std::vector<VolumeSample> kept;
    std::vector<Eigen::Vector3d> points;
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (const auto spot =
                triangulate(model.channels[samples[i].channel], samples[i].pixel, samples[i].s)) {
            response.kept.push_back(i);
            kept.push_back(samples[i]);
            points.push_back(spot->point_in_scan);
        }
    const Eigen::Index count = model.covariance.rows();
    if (kept.size() < 4 || count == 0) return {};

    response.by_sigma = Eigen::MatrixXd::Zero(3 * Eigen::Index(kept.size()), count);
    const Eigen::VectorXd sigma = model.covariance.diagonal().cwiseMax(0).cwiseSqrt();
    for (Eigen::Index i = 0; i < count; ++i)
        if (sigma[i] > 0)
            response.by_sigma.col(i) =
                sigma[i] * points_moved(model, kept, i, std::min(1e-4, sigma[i]));
    const Eigen::MatrixXd motions = rigid_motions(points);
    response.by_sigma -= motions * motions.householderQr().solve(response.by_sigma);

    // Correlation instead of covariance: of a parameter in units of its own sigma.
    const Eigen::VectorXd inverse = sigma.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
    response.correlation = inverse.asDiagonal() * model.covariance * inverse.asDiagonal();
    return response;
}

Eigen::Matrix3d covariance_of(const PointResponse& response, std::size_t kept) {
    const auto rows = response.by_sigma.middleRows<3>(3 * static_cast<Eigen::Index>(kept));
    return rows * response.correlation * rows.transpose();
}

}  // namespace

std::vector<Eigen::Matrix3d> predict_covariance(const ScannerModel& model,
                                                const std::vector<VolumeSample>& samples) {
    const PointResponse response = respond(model, samples);
    if (response.kept.empty()) return {};
    std::vector<Eigen::Matrix3d> all(samples.size(), Eigen::Matrix3d::Zero());
    for (std::size_t i = 0; i < response.kept.size(); ++i)
        all[response.kept[i]] = covariance_of(response, i);
    return all;
}

PredictedSigma predict_sigma(const ScannerModel& model, const std::vector<VolumeSample>& samples) {
    const PointResponse response = respond(model, samples);
    if (response.kept.empty()) return {};
    std::vector<double> lengths;
    double sum = 0;
    for (std::size_t i = 0; i < response.kept.size(); ++i) {
        const double variance = covariance_of(response, i).trace();
        lengths.push_back(std::sqrt(std::max(0.0, variance)));
        sum += variance;
    }
    std::sort(lengths.begin(), lengths.end());
    PredictedSigma predicted;
    predicted.median_mm = lengths[lengths.size() / 2];
    predicted.p95_mm = lengths[lengths.size() * 95 / 100];
    predicted.rms_mm = std::sqrt(sum / static_cast<double>(lengths.size()));

    // The combination of parameters that moves the points most, and its largest part.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> parts(response.correlation);
    const Eigen::MatrixXd root =
        parts.eigenvectors() * parts.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
    const Eigen::MatrixXd effect = response.by_sigma * root;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(
        Eigen::MatrixXd(effect.transpose() * effect));
    const Eigen::VectorXd worst = root * modes.eigenvectors().rightCols<1>();
    Eigen::Index largest = 0;
    worst.cwiseAbs().maxCoeff(&largest);
    predicted.weakest = parameter_names(model)[static_cast<std::size_t>(largest)];
    return predicted;
}

}  // namespace stria
