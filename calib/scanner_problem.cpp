#include "calib/scanner_problem.h"

#include <ceres/normal_prior.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numeric>

#include "calib/scanner_residuals.h"
#include "calib/schur_information.h"

namespace stria {
namespace {

std::vector<int> first_entries(int count) {
    std::vector<int> all(static_cast<std::size_t>(count));
    std::iota(all.begin(), all.end(), 0);
    return all;
}

/// Entries of [0, size) that are not free; the camera block's tail a lens kind does not use.
std::vector<int> held_entries(int size, const std::vector<int>& free) {
    std::vector<int> held;
    for (int i = 0; i < size; ++i)
        if (std::find(free.begin(), free.end(), i) == free.end()) held.push_back(i);
    return held;
}

void hold_entries(ceres::Problem& problem, double* block, int size, const std::vector<int>& free) {
    if (!problem.HasParameterBlock(block)) return;
    const auto held = held_entries(size, free);
    if (held.size() == static_cast<std::size_t>(size))
        problem.SetParameterBlockConstant(block);
    else if (!held.empty())
        problem.SetManifold(block, new ceres::SubsetManifold(size, held));
}

}  // namespace

ScannerProblem::ScannerProblem(const Board& board, const Channel& nominal,
                               const ScannerCalibrationOptions& options)
    : points_(board_points(board)), nominal_(nominal), options_(options) {
    set_channel(nominal);
}

void ScannerProblem::set_channel(const Channel& channel) {
    base_ = channel;
    Eigen::Map<Eigen::Matrix<double, kCameraSize, 1>>(camera_.data()) =
        camera_block(channel.camera);
    sheet_.fill(0);
    axis_.fill(0);
}

ScannerProblem::Stage ScannerProblem::everything() const {
    Stage stage;
    stage.sheet_free = first_entries(kSheetSize);
    stage.axis_free = base_.axis.kind == MachineKind::turntable
                          ? std::vector<int>{0, 1, 3, 4}
                          : first_entries(axis_size(base_.axis.kind));
    return stage;
}

template <MachineKind kKind>
void ScannerProblem::add_residuals(ceres::Problem& problem, const Stage& stage) {
    constexpr int kAxis = axis_size(kKind);
    const auto loss = [&]() -> ceres::LossFunction* {
        return stage.huber_sigmas > 0 ? new ceres::HuberLoss(stage.huber_sigmas) : nullptr;
    };
    const auto light = std::make_shared<LightAt<kKind>>();
    int count = 0;
    for (View& view : views) {
        for (const Corner& corner : view.corners) {
            if (!stage.corners || !corner.use) continue;
            const Eigen::Vector3d& point = points_[static_cast<std::size_t>(corner.id)];
            if constexpr (kKind == MachineKind::swept)
                problem.AddResidualBlock(
                    new ceres::AutoDiffCostFunction<StillCornerCost, 2, kCameraSize, kPoseSize>(
                        new StillCornerCost{point, corner.pixel, 1 / corner_sigma_px}),
                    loss(), camera_.data(), view.pose.data());
            else
                problem.AddResidualBlock(
                    new ceres::AutoDiffCostFunction<CornerCost<kKind>, 2, kCameraSize, kAxis,
                                                    kPoseSize>(new CornerCost<kKind>{
                        &base_, point, corner.pixel, corner.s, 1 / corner_sigma_px}),
                    loss(), camera_.data(), axis_.data(), view.pose.data());
        }
        for (const Stripe& stripe : view.stripes) {
            if (!stripe.use) continue;
            if (stage.every > 1 && count++ % stage.every != 0) continue;
            problem.AddResidualBlock(
                new StripeCost<kKind>(&base_, light, stripe.point.pixel, stripe.point.s,
                                      stripe.sigma_mm * stripe_sigma_factor),
                loss(), camera_.data(), sheet_.data(), axis_.data(), view.pose.data());
        }
    }
}

template <MachineKind kKind>
void ScannerProblem::add_prior(ceres::Problem& problem) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<NominalCost<kKind>, kPriorSize, kSheetSize,
                                        axis_size(kKind)>(new NominalCost<kKind>{
            &base_, &nominal_, options_.nominal_angle_sigma_rad, options_.nominal_length_sigma_mm,
            options_.bow_sigma, options_.gain_sigma}),
        nullptr, sheet_.data(), axis_.data());
}

void ScannerProblem::build(ceres::Problem& problem, const Stage& stage) {
    switch (base_.axis.kind) {
        case MachineKind::swept:
            add_residuals<MachineKind::swept>(problem, stage);
            add_prior<MachineKind::swept>(problem);
            break;
        case MachineKind::rail:
            add_residuals<MachineKind::rail>(problem, stage);
            add_prior<MachineKind::rail>(problem);
            break;
        case MachineKind::turntable:
            add_residuals<MachineKind::turntable>(problem, stage);
            add_prior<MachineKind::turntable>(problem);
            break;
    }
    hold(problem, stage);
}

void ScannerProblem::hold(ceres::Problem& problem, const Stage& stage) {
    if (stage.camera) {
        hold_entries(problem, camera_.data(), kCameraSize,
                     first_entries(4 + distortion_count(base_.camera.kind)));
    } else {
        if (problem.HasParameterBlock(camera_.data()))
            problem.SetParameterBlockConstant(camera_.data());
        for (View& view : views)
            if (problem.HasParameterBlock(view.pose.data()))
                problem.SetParameterBlockConstant(view.pose.data());
    }
    hold_entries(problem, sheet_.data(), kSheetSize, stage.sheet_free);
    hold_entries(problem, axis_.data(), axis_size(base_.axis.kind), stage.axis_free);
}

/// Turning m0 about the mirror's axis can be undone, nearly without a trace, by turning the
/// incoming sheet the other way; a solver creeps along that curved valley for hundreds of steps.
/// This holds the turn to about 1e-3 rad a solve. Each solve starts anew from the present estimate,
/// so it slows that direction and favours no value; the covariance leaves it out.
void ScannerProblem::damp_mirror_turn(ceres::Problem& problem) {
    if (base_.axis.kind != MachineKind::swept || !problem.HasParameterBlock(axis_.data())) return;
    constexpr double kTurnRad = 1e-3;
    constexpr int kNormalA = 4, kNormalB = 5;  // of the axis block, as in parameter_names()
    Eigen::Vector3d a, b;
    tangent_basis(base_.axis.mirror.normal0, a, b);
    constexpr int kAxis = axis_size(MachineKind::swept);
    Eigen::MatrixXd turn = Eigen::MatrixXd::Zero(1, kAxis);
    turn(0, kNormalA) = a.dot(base_.axis.mirror.direction) / kTurnRad;
    turn(0, kNormalB) = b.dot(base_.axis.mirror.direction) / kTurnRad;
    problem.AddResidualBlock(new ceres::NormalPrior(turn, Eigen::VectorXd::Zero(kAxis)), nullptr,
                             axis_.data());
}

ceres::Solver::Summary ScannerProblem::solve(const Stage& stage) {
    ceres::Problem problem;
    build(problem, stage);
    damp_mirror_turn(problem);
    ceres::Solver::Options options;
    options.linear_solver_type = stage.camera ? ceres::DENSE_SCHUR : ceres::DENSE_QR;
    if (!stage.camera) options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = stage.max_iterations;
    options.function_tolerance = stage.huber_sigmas > 0 ? 1e-6 : 1e-9;
    options.parameter_tolerance = 1e-11;
    options.gradient_tolerance = 1e-14;
    // The start is near and the priors keep the problem regular: steps close to Gauss-Newton's, or
    // the mirror's weak directions take a hundred of them.
    options.initial_trust_region_radius = 1e9;
    options.max_trust_region_radius = 1e18;
    if (stage.camera) {
        auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
        for (View& view : views)
            if (problem.HasParameterBlock(view.pose.data()))
                ordering->AddElementToGroup(view.pose.data(), 0);
        for (double* block : {camera_.data(), sheet_.data(), axis_.data()})
            if (problem.HasParameterBlock(block)) ordering->AddElementToGroup(block, 1);
        options.linear_solver_ordering = ordering;
    }
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    rebase();
    return summary;
}

void ScannerProblem::rebase() {
    set_from_block(base_.camera, camera_.data());
    ScannerModel model;
    model.channels = {base_};
    const int lens = 4 + distortion_count(base_.camera.kind);
    const int axis = axis_size(base_.axis.kind);
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(lens + kSheetSize + axis + 1);
    for (int i = 0; i < kSheetSize; ++i) delta[lens + i] = sheet_[static_cast<std::size_t>(i)];
    for (int i = 0; i < axis; ++i)
        delta[lens + kSheetSize + i] = axis_[static_cast<std::size_t>(i)];
    Channel moved = perturbed(model, delta).channels[0];
    if (moved.axis.kind == MachineKind::swept) {
        // The point of the axis nearest the camera again; moving it along the axis moves h.
        MirrorAxis& mirror = moved.axis.mirror;
        mirror.direction.normalize();
        mirror.normal0.normalize();
        const double along = mirror.point.dot(mirror.direction);
        mirror.offset_mm += along * mirror.normal0.dot(mirror.direction);
        mirror.point -= along * mirror.direction;
    }
    set_channel(moved);
}

void ScannerProblem::weigh_stripes() {
    for (View& view : views) {
        const Rigid3 pose = rigid_from_block(view.pose.data());
        for (Stripe& stripe : view.stripes)
            stripe.sigma_mm = sigma_on_board_mm(base_, pose, stripe.point);
    }
}

Eigen::Vector2d ScannerProblem::residual(const View& view, const Corner& corner) const {
    const Rigid3 pose = board_motion(base_, corner.s) * rigid_from_block(view.pose.data());
    const auto pixel = project(base_.camera, pose * points_[static_cast<std::size_t>(corner.id)]);
    return pixel ? Eigen::Vector2d(*pixel - corner.pixel) : Eigen::Vector2d::Constant(1e6);
}

double ScannerProblem::residual_mm(const View& view, const Stripe& stripe) const {
    return distance_on_board(base_, rigid_from_block(view.pose.data()), stripe.point.pixel,
                             stripe.point.s);
}

Eigen::MatrixXd ScannerProblem::covariance() {
    const Stage stage = everything();
    ceres::Problem problem;
    build(problem, stage);
    std::vector<double*> separate;
    for (View& view : views)
        if (problem.HasParameterBlock(view.pose.data())) separate.push_back(view.pose.data());
    const Eigen::MatrixXd information =
        schur_information(problem, {camera_.data(), sheet_.data(), axis_.data()}, separate);
    const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
        Eigen::MatrixXd(scale.asDiagonal() * information * scale.asDiagonal()));
    const Eigen::MatrixXd small = scale.asDiagonal() * eigen.eigenvectors() *
                                  eigen.eigenvalues().cwiseMax(1e-14).cwiseInverse().asDiagonal() *
                                  eigen.eigenvectors().transpose() * scale.asDiagonal();

    // Rows of the free parameters among all that parameter_names() lists.
    const int lens = 4 + distortion_count(base_.camera.kind);
    const int axis = axis_size(base_.axis.kind);
    std::vector<int> rows = first_entries(lens);
    for (int i : stage.sheet_free) rows.push_back(lens + i);
    for (int i : stage.axis_free) rows.push_back(lens + kSheetSize + i);
    const int all = lens + kSheetSize + axis + 1;
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(all, all);
    for (std::size_t i = 0; i < rows.size(); ++i)
        for (std::size_t j = 0; j < rows.size(); ++j)
            full(rows[i], rows[j]) =
                small(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    return full;
}

}  // namespace stria
