#include "calib/coach.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "calib/point_moves.h"
#include "host/core/errors.h"
#include "host/core/short_number.h"

namespace stria {
namespace {

constexpr double kTiltsRad[] = {0.45, 0.75};          ///< 26 and 43 deg: corners stand that
constexpr double kSamePlaceMm = 10, kSameTurn = 0.1;  ///< of placements, after a better model
constexpr int kMostStripes = 100;                     ///< of a measured view: more only costs time

/// Rotation vectors: facing the camera, and to four sides.
std::vector<Eigen::Vector3d> tilts() {
    std::vector<Eigen::Vector3d> all = {Eigen::Vector3d::Zero()};
    for (const double tilt : kTiltsRad)
        for (const double sign : {1.0, -1.0}) {
            all.push_back(sign * tilt * Eigen::Vector3d::UnitX());
            all.push_back(sign * tilt * Eigen::Vector3d::UnitY());
        }
    return all;
}

}  // namespace

Coach::Coach(const Board& board, const ScannerModel& drawing, const CoachOptions& options)
    : board_(board), options_(options) {
    modes_ = covariance_modes(drawing_covariance(drawing, options.calibration));
    information_ = Eigen::MatrixXd::Identity(modes_.cols(), modes_.cols());
    if (!(options_.far_mm > options_.near_mm)) {
        const Eigen::Vector2d range = working_distance_mm(
            drawing.channels.front(), options.plan.sweep_from, options.plan.sweep_to);
        options_.near_mm = range[0];
        options_.far_mm = range[1];
    }
    if (options_.mode == StripeMode::spacetime && options_.plan.stripe_sigma_mm == 0)
        options_.plan.stripe_sigma_mm = options_.plan.stripe_sigma_px * 0.5 *
                                        (options_.near_mm + options_.far_mm) /
                                        drawing.channels.front().camera.fx;
    follow(drawing);
}

void Coach::follow(const ScannerModel& model) {
    model_ = model;
    const auto samples = field_samples(model_.channels.front(), options_.plan.sweep_from,
                                       options_.plan.sweep_to, options_.near_mm, options_.far_mm);
    if (samples.size() < 4)
        throw Error("the laser's sheet does not meet the camera's field between " +
                    short_number(options_.near_mm) + " and " + short_number(options_.far_mm) +
                    " mm during the sweep: expected a drawing and a plan that fit the machine");
    moves_ = point_moves(model_, modes_, samples);
    placements_.clear();
    for (const Rigid3& pose : library()) {
        const ViewData view = expected_view(model_, board_, pose, options_.plan);
        if (!view.corners.empty())
            placements_.push_back({pose, information_of(view_rows(model_, modes_, view))});
    }
}

ViewData Coach::data_of(const CornerView& view) const {
    return measured_view(model_, board_, view, options_.plan.corner_sigma_px, 1.0, kMostStripes);
}

bool Coach::can_use(const CornerView& view) const {
    const ViewData data = data_of(view);
    return !data.corners.empty() && !data.stripes.empty();
}

bool Coach::take(const CornerView& view) {
    const ViewData data = data_of(view);
    if (data.corners.empty() || data.stripes.empty()) return false;
    information_ += information_of(view_rows(model_, modes_, data));
    taken_.push_back(data.camera_from_board);
    return true;
}

void Coach::avoid(const Rigid3& camera_from_board) { avoided_.push_back(camera_from_board); }

bool Coach::is_avoided(const Rigid3& pose) const {
    return std::any_of(avoided_.begin(), avoided_.end(), [&](const Rigid3& other) {
        return (pose.translation - other.translation).norm() < kSamePlaceMm &&
               (pose.rotation - other.rotation).norm() < kSameTurn;
    });
}

double Coach::sigma_mm() const {
    const Eigen::MatrixXd effect = moves_.transpose() * moves_;
    const double points = static_cast<double>(moves_.rows()) / 3;
    return std::sqrt(information_.ldlt().solve(effect).trace() / points);
}

std::vector<Rigid3> Coach::library() const {
    const CameraModel& camera = model_.channels.front().camera;
    const auto points = board_points(board_);
    const Eigen::Vector3d middle = 0.5 * (points.front() + points.back());
    std::vector<Rigid3> all;
    int count = 0;
    for (const double share : {0.0, 0.5, 1.0})
        for (const double u : {0.15, 0.3, 0.5, 0.7, 0.85})
            for (const double v : {0.15, 0.3, 0.5, 0.7, 0.85})
                for (const Eigen::Vector3d& tilt : tilts()) {
                    const Eigen::Vector3d ray =
                        ray_through(camera, {u * camera.width, v * camera.height});
                    const double depth =
                        options_.near_mm + share * (options_.far_mm - options_.near_mm);
                    const double roll = count++ % 2 == 0 ? 0 : 1.5707963267948966;
                    const Eigen::Matrix3d rotation =
                        rotation_from_vector(tilt) * rotation_from_vector({0, 0, roll});
                    all.push_back({rotation, depth * ray / ray.z() - rotation * middle});
                }
    return all;
}

std::string Coach::weakest() const {
    // The combination of modes that moves the points most, and its largest part in units of what is
    // known of each parameter.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> parts(information_);
    const Eigen::MatrixXd root =
        parts.eigenvectors() * parts.eigenvalues().cwiseInverse().cwiseSqrt().asDiagonal();
    const Eigen::MatrixXd effect = moves_ * root;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> worst(
        Eigen::MatrixXd(effect.transpose() * effect));
    const Eigen::MatrixXd by_parameter = modes_ * root;
    const Eigen::VectorXd moved = by_parameter * worst.eigenvectors().rightCols(1);
    Eigen::Index largest = 0;
    double most = -1;
    for (Eigen::Index i = 0; i < moved.size(); ++i) {
        const double sigma = by_parameter.row(i).norm();
        if (sigma > 0 && std::abs(moved[i]) / sigma > most) {
            most = std::abs(moved[i]) / sigma;
            largest = i;
        }
    }
    return in_words(parameter_names(model_)[static_cast<std::size_t>(largest)]);
}

CoachAdvice Coach::advise() const {
    const Eigen::MatrixXd effect = moves_.transpose() * moves_;
    const double points = static_cast<double>(moves_.rows()) / 3;
    CoachAdvice advice;
    advice.sigma_now_mm = sigma_mm();
    advice.weakest = weakest();
    double best = -1;
    for (const Placement& placement : placements_) {
        if (is_avoided(placement.camera_from_board)) continue;
        const Eigen::MatrixXd then = information_ + placement.information;
        const double trace = then.ldlt().solve(effect).trace();
        if (best >= 0 && trace >= best) continue;
        best = trace;
        advice.camera_from_board = placement.camera_from_board;
    }
    if (best < 0)
        throw Error(
            "no placement of board " + to_string(board_) + " between " +
            short_number(options_.near_mm) + " and " + short_number(options_.far_mm) +
            " mm shows 60 % of its corners and the stripe, and has not failed before: expected "
            "a board that fits the image, or a plan whose pictures all see it");
    advice.sigma_then_mm = std::sqrt(best / points);
    advice.place = "hold the board " + describe_placement(model_.channels.front().camera, board_,
                                                          advice.camera_from_board);
    advice.text = advice.place + ". A point is known to " + short_number(advice.sigma_now_mm, 2) +
                  " mm so far, then to " + short_number(advice.sigma_then_mm, 2) +
                  " mm; weakest: " + advice.weakest;
    return advice;
}

}  // namespace stria
