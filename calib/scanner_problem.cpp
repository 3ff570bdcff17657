#include "calib/scanner_problem.h"

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

ScannerProblem::ScannerProblem(const Board& board, const std::vector<Channel>& nominal,
                               const ScannerCalibrationOptions& options)
    : warp{board.warp_mm.x(), board.warp_mm.y()},
      rise_(board_points(board)),
      base_(nominal),
      nominal_(nominal),
      options_(options),
      sheets_(nominal.size()) {
    set_camera_and_axis(nominal.front().camera, nominal.front().axis);
    for (const Eigen::Vector3d& p : board_points(board))
        points_.push_back({p.head<2>(), rise_.at(p.head<2>())});
}

void ScannerProblem::set_camera_and_axis(const CameraModel& camera, const AxisModel& axis) {
    for (Channel& channel : base_) {
        channel.camera = camera;
        channel.axis = axis;
    }
    Eigen::Map<Eigen::Matrix<double, kCameraSize, 1>>(camera_.data()) = camera_block(camera);
    for (auto& sheet : sheets_) sheet.fill(0);
    axis_.fill(0);
}

bool ScannerProblem::sees_delay() const {
    std::size_t forward = 0, back = 0;
    for (const View& view : views)
        for (const Stripe& stripe : view.stripes) {
            forward += stripe.point.ds_dt > 0;
            back += stripe.point.ds_dt < 0;
        }
    return 10 * std::min(forward, back) > forward + back;
}

ScannerProblem::Stage ScannerProblem::everything() const {
    const MachineKind kind = base_.front().axis.kind;
    Stage stage;
    stage.sheet_free = first_entries(kSheetSize);
    stage.axis_free = kind == MachineKind::turntable ? std::vector<int>{0, 1, 3, 4}
                                                     : first_entries(axis_size(kind) - 1);
    if (sees_delay()) stage.axis_free.push_back(axis_size(kind) - 1);
    stage.warp = options_.board_warp;
    return stage;
}

int ScannerProblem::corner_unknowns() const {
    const Channel& any = base_.front();
    const int axis =
        any.axis.kind == MachineKind::swept ? 0 : static_cast<int>(everything().axis_free.size());
    return 4 + distortion_count(any.camera.kind) + axis + (options_.board_warp ? kWarpSize : 0) +
           6 * static_cast<int>(views.size());
}

int ScannerProblem::stripe_unknowns() const {
    const int axis = base_.front().axis.kind == MachineKind::swept
                         ? static_cast<int>(everything().axis_free.size())
                         : 0;
    return kSheetSize * static_cast<int>(base_.size()) + axis;
}

template <MachineKind kKind>
void ScannerProblem::add_corner(ceres::Problem& problem, View& view, const Corner& corner,
                                ceres::LossFunction* loss) {
    constexpr int kAxis = axis_size(kKind);
    const BoardPoint& point = points_[static_cast<std::size_t>(corner.id)];
    if constexpr (kKind == MachineKind::swept)
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<StillCornerCost, 2, kCameraSize, kPoseSize, kWarpSize>(
                new StillCornerCost{point, corner.pixel, 1 / corner_sigma_px}),
            loss, camera_.data(), view.pose.data(), warp.data());
    else
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<CornerCost<kKind>, 2, kCameraSize, kAxis, kPoseSize,
                                            kWarpSize>(new CornerCost<kKind>{
                &base_.front(), point, corner.pixel, corner.s, 1 / corner_sigma_px}),
            loss, camera_.data(), axis_.data(), view.pose.data(), warp.data());
}

template <MachineKind kKind>
void ScannerProblem::add_residuals(ceres::Problem& problem, const Stage& stage) {
    const auto loss = [&]() -> ceres::LossFunction* {
        return stage.huber_sigmas > 0 ? new ceres::HuberLoss(stage.huber_sigmas) : nullptr;
    };
    std::vector<std::shared_ptr<LightAt<kKind>>> lights;
    for (std::size_t c = 0; c < base_.size(); ++c)
        lights.push_back(std::make_shared<LightAt<kKind>>());
    int count = 0;
    for (View& view : views) {
        for (const Corner& corner : view.corners)
            if (stage.corners && corner.use) add_corner<kKind>(problem, view, corner, loss());
        for (const Stripe& stripe : view.stripes) {
            if (!stripe.use) continue;
            if (stage.every > 1 && count++ % stage.every != 0) continue;
            const std::size_t c = stripe.channel;
            problem.AddResidualBlock(
                new StripeCost<kKind>(&base_[c], lights[c], stripe.point, stripe.rise,
                                      stripe.sigma_mm * stripe_sigma_factor),
                loss(), camera_.data(), sheets_[c].data(), axis_.data(), view.pose.data(),
                warp.data());
        }
    }
}

template <MachineKind kKind>
void ScannerProblem::add_priors(ceres::Problem& problem) {
    const NominalSigmas sigmas = {options_.nominal_angle_sigma_rad,
                                  options_.nominal_length_sigma_mm, options_.bow_sigma,
                                  options_.gain_sigma, options_.delay_sigma_ns};
    using Sheet = SheetPrior<kKind>;
    using Axis = AxisPrior<kKind>;
    for (std::size_t c = 0; c < base_.size(); ++c)
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<Sheet, Sheet::kSize, kSheetSize, axis_size(kKind)>(
                new Sheet{&base_[c], &nominal_[c].sheet, sigmas}),
            nullptr, sheets_[c].data(), axis_.data());
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Axis, Axis::kSize, axis_size(kKind)>(
                                 new Axis{&base_.front(), &nominal_.front().axis, sigmas}),
                             nullptr, axis_.data());
    if (options_.board_warp)
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<WarpPrior, kWarpSize, kWarpSize>(
                                     new WarpPrior{options_.warp_sigma_mm}),
                                 nullptr, warp.data());
}

void ScannerProblem::build(ceres::Problem& problem, const Stage& stage) {
    switch (base_.front().axis.kind) {
        case MachineKind::swept:
            add_residuals<MachineKind::swept>(problem, stage);
            add_priors<MachineKind::swept>(problem);
            break;
        case MachineKind::rail:
            add_residuals<MachineKind::rail>(problem, stage);
            add_priors<MachineKind::rail>(problem);
            break;
        case MachineKind::turntable:
            add_residuals<MachineKind::turntable>(problem, stage);
            add_priors<MachineKind::turntable>(problem);
            break;
    }
    hold(problem, stage);
}

void ScannerProblem::hold(ceres::Problem& problem, const Stage& stage) {
    if (stage.camera) {
        hold_entries(problem, camera_.data(), kCameraSize,
                     first_entries(4 + distortion_count(base_.front().camera.kind)));
    } else {
        if (problem.HasParameterBlock(camera_.data()))
            problem.SetParameterBlockConstant(camera_.data());
        for (View& view : views)
            if (problem.HasParameterBlock(view.pose.data()))
                problem.SetParameterBlockConstant(view.pose.data());
    }
    if (!stage.warp && problem.HasParameterBlock(warp.data()))
        problem.SetParameterBlockConstant(warp.data());
    for (auto& sheet : sheets_) hold_entries(problem, sheet.data(), kSheetSize, stage.sheet_free);
    hold_entries(problem, axis_.data(), axis_size(base_.front().axis.kind), stage.axis_free);
}

/// The stripes hardly see the mirror turn while its sheet follows: far from the minimum a step
/// along that direction may be any number of radians, into a false solution on the mirror's other
/// side. So the mirror stays within kMostMirrorTurn of its drawing.
void ScannerProblem::bound_mirror_turn(ceres::Problem& problem) {
    if (base_.front().axis.kind != MachineKind::swept || !problem.HasParameterBlock(axis_.data()))
        return;
    const Eigen::Vector3d& now = base_.front().axis.mirror.normal0;
    const Eigen::Vector3d turned = nominal_.front().axis.mirror.normal0.cross(now);
    Eigen::Vector3d by[2];
    tangent_basis(now, by[0], by[1]);
    const double most = kMostMirrorTurn * options_.nominal_angle_sigma_rad;
    for (int i = 0; i < 2; ++i) {
        const double so_far = turned.dot(by[i]);
        problem.SetParameterLowerBound(axis_.data(), 4 + i, std::min(0.0, -most - so_far));
        problem.SetParameterUpperBound(axis_.data(), 4 + i, std::max(0.0, most - so_far));
    }
}

SolveEnd ScannerProblem::solve(const Stage& stage) {
    ceres::Problem problem;
    build(problem, stage);
    if (stage.mirror_bounded) bound_mirror_turn(problem);
    ceres::Solver::Options options;
    options.linear_solver_type = stage.camera ? ceres::DENSE_SCHUR : ceres::DENSE_NORMAL_CHOLESKY;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = stage.max_iterations;
    options.function_tolerance = stage.huber_sigmas > 0 ? 1e-6 : 1e-9;
    options.parameter_tolerance = 1e-11;
    options.gradient_tolerance = 1e-14;
    // The start is near and the priors keep the problem regular: steps close to Gauss-Newton's, or
    // the mirror's weak directions take a hundred of them.
    options.initial_trust_region_radius = 1e9;
    options.max_trust_region_radius = 1e18;
    std::vector<double*> shared = {camera_.data(), axis_.data()}, poses;
    for (auto& sheet : sheets_) shared.push_back(sheet.data());
    if (stage.warp) shared.push_back(warp.data());
    for (View& view : views) poses.push_back(view.pose.data());
    if (stage.camera) {
        auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
        for (double* block : poses)
            if (problem.HasParameterBlock(block)) ordering->AddElementToGroup(block, 0);
        for (double* block : shared)
            if (problem.HasParameterBlock(block)) ordering->AddElementToGroup(block, 1);
        options.linear_solver_ordering = ordering;
    }
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    SolveEnd end = {summary.initial_cost, summary.final_cost,
                    static_cast<int>(summary.iterations.size()) - 1,
                    summary.termination_type == ceres::CONVERGENCE};
    if (!end.converged && stage.valley_iterations > 0) {
        const SolveEnd further = valley_solve(problem, shared, poses, stage.valley_iterations);
        end.final_cost = further.final_cost;
        end.iterations += further.iterations;
        end.converged = further.converged;
    }
    rebase();
    return end;
}

double ScannerProblem::cost(const Stage& stage) {
    ceres::Problem problem;
    build(problem, stage);
    double cost = 0;
    problem.Evaluate({}, &cost, nullptr, nullptr, nullptr);
    return cost;
}

void ScannerProblem::rebase() {
    const MachineKind kind = base_.front().axis.kind;
    for (std::size_t c = 0; c < base_.size(); ++c) {
        const double* by = sheets_[c].data();
        const SheetOf<double> moved = kind == MachineKind::swept
                                          ? sheet_of<MachineKind::swept>(base_[c], by, axis_.data())
                                          : sheet_of<MachineKind::rail>(base_[c], by, axis_.data());
        LaserSheet& sheet = base_[c].sheet;
        sheet.normal = moved.normal;
        sheet.offset_mm = moved.offset;
        sheet.apex = moved.apex;
        sheet.central_ray = moved.central_ray;
        sheet.bow2 = moved.bow2;
        sheet.bow3 = moved.bow3;
        sheet = normalised(sheet);
    }
    CameraModel camera = base_.front().camera;
    set_from_block(camera, camera_.data());
    const int before = 4 + distortion_count(camera.kind) + kSheetSize;
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(before + axis_size(kind));
    delta.tail(axis_size(kind)) = Eigen::Map<Eigen::VectorXd>(axis_.data(), axis_size(kind));
    ScannerModel model;
    model.channels = {base_.front()};
    AxisModel axis = perturbed(model, delta).channels[0].axis;
    if (kind == MachineKind::swept) {
        // The point of the axis nearest the camera again; moving it along the axis moves h.
        MirrorAxis& mirror = axis.mirror;
        mirror.direction.normalize();
        mirror.normal0.normalize();
        const double along = mirror.point.dot(mirror.direction);
        mirror.offset_mm += along * mirror.normal0.dot(mirror.direction);
        mirror.point -= along * mirror.direction;
    }
    set_camera_and_axis(camera, axis);
}

void ScannerProblem::weigh_stripes() {
    for (View& view : views) {
        const Rigid3 pose = rigid_from_block(view.pose.data());
        for (Stripe& stripe : view.stripes) {
            const Channel& channel = base_[stripe.channel];
            stripe.sigma_mm = sigma_on_board_mm(channel, pose, stripe.point);
            const Rigid3 at_s =
                board_motion(channel, axis_position(stripe.point, channel.axis)) * pose;
            stripe.rise = rise_seen(channel.camera, at_s, stripe.point.pixel, rise_,
                                    Eigen::Vector2d(warp[0], warp[1]));
        }
    }
}

Eigen::Vector2d ScannerProblem::residual(const View& view, const Corner& corner) const {
    const Channel& any = base_.front();
    const Rigid3 pose = board_motion(any, corner.s) * rigid_from_block(view.pose.data());
    const BoardPoint& point = points_[static_cast<std::size_t>(corner.id)];
    const auto pixel = project(any.camera, pose * point.bent_by(warp.data()));
    return pixel ? Eigen::Vector2d(*pixel - corner.pixel) : Eigen::Vector2d::Constant(1e6);
}

double ScannerProblem::residual_mm(const View& view, const Stripe& stripe) const {
    const Channel& channel = base_[stripe.channel];
    return distance_on_board(channel, rigid_from_block(view.pose.data()), stripe.point.pixel,
                             axis_position(stripe.point, channel.axis),
                             stripe.rise.dot(Eigen::Vector2d(warp[0], warp[1])));
}

std::vector<double> ScannerProblem::stripe_residuals() const {
    std::vector<double> residuals;
    for (const auto& view : views)
        for (const auto& stripe : view.stripes)
            if (stripe.use) residuals.push_back(residual_mm(view, stripe) / stripe.sigma_mm);
    return residuals;
}

std::vector<double> ScannerProblem::corner_residuals() const {
    std::vector<double> residuals;
    for (const auto& view : views)
        for (const auto& corner : view.corners)
            if (corner.use) {
                const Eigen::Vector2d r = residual(view, corner);
                residuals.push_back(r.x());
                residuals.push_back(r.y());
            }
    return residuals;
}

/// Derivative of the parameters that parameter_names() lists by the free ones of a stage (camera,
/// then each sheet, then axis). Equal but for two things: channels repeat what they share, and a
/// swept machine's sheets follow the mirror's turn, see following_sheet().
Eigen::MatrixXd ScannerProblem::names_from_free(const Stage& stage) const {
    const MachineKind kind = base_.front().axis.kind;
    const int lens = 4 + distortion_count(base_.front().camera.kind);
    const auto sheet_free = static_cast<int>(stage.sheet_free.size());
    const auto axis_free = static_cast<int>(stage.axis_free.size());
    const int channels = static_cast<int>(base_.size());
    const int each = lens + kSheetSize + axis_size(kind);
    const int axis_column = lens + channels * sheet_free;
    Eigen::MatrixXd by = Eigen::MatrixXd::Zero(channels * each, axis_column + axis_free);
    for (int c = 0; c < channels; ++c) {
        const int row = c * each, sheet_row = row + lens;
        by.block(row, 0, lens, lens).setIdentity();
        for (int i = 0; i < sheet_free; ++i)
            by(sheet_row + stage.sheet_free[static_cast<std::size_t>(i)],
               lens + c * sheet_free + i) = 1;
        for (int i = 0; i < axis_free; ++i)
            by(sheet_row + kSheetSize + stage.axis_free[static_cast<std::size_t>(i)],
               axis_column + i) = 1;
        if (kind != MachineKind::swept) continue;
        const MirrorAxis& mirror = base_.front().axis.mirror;
        const Eigen::Vector3d& normal = base_[static_cast<std::size_t>(c)].sheet.normal;
        Eigen::Vector3d a, b, ma, mb;
        tangent_basis(normal, a, b);
        tangent_basis(mirror.normal0, ma, mb);
        const double turn[2] = {ma.dot(mirror.direction), mb.dot(mirror.direction)};
        for (int i = 0; i < axis_free; ++i) {
            const int entry = stage.axis_free[static_cast<std::size_t>(i)];
            if (entry != 4 && entry != 5) continue;
            const double twice = 2 * turn[entry - 4];
            by(sheet_row, axis_column + i) = twice * a.dot(mirror.direction);
            by(sheet_row + 1, axis_column + i) = twice * b.dot(mirror.direction);
            by(sheet_row + 2, axis_column + i) =
                twice * mirror.direction.cross(normal).dot(mirror.point);
        }
    }
    return by;
}

Eigen::MatrixXd ScannerProblem::covariance() {
    const Stage stage = everything();
    ceres::Problem problem;
    build(problem, stage);
    std::vector<double*> separate;
    for (View& view : views)
        if (problem.HasParameterBlock(view.pose.data())) separate.push_back(view.pose.data());
    std::vector<double*> shared = {camera_.data()};
    for (auto& sheet : sheets_) shared.push_back(sheet.data());
    shared.push_back(axis_.data());
    if (stage.warp) shared.push_back(warp.data());
    const Eigen::MatrixXd information = schur_information(problem, shared, separate);
    const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
        Eigen::MatrixXd(scale.asDiagonal() * information * scale.asDiagonal()));
    const Eigen::MatrixXd small = scale.asDiagonal() * eigen.eigenvectors() *
                                  eigen.eigenvalues().cwiseMax(1e-14).cwiseInverse().asDiagonal() *
                                  eigen.eigenvectors().transpose() * scale.asDiagonal();
    if (stage.warp) warp_sigma_mm = small.diagonal().tail<kWarpSize>().cwiseSqrt();
    const Eigen::MatrixXd by = names_from_free(stage);
    const Eigen::Index named = by.cols();
    return by * small.topLeftCorner(named, named) * by.transpose();
}

}  // namespace stria
