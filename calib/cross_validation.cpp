#include "calib/cross_validation.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "calib/point_moves.h"
#include "calib/projected_view.h"
#include "host/core/p_values.h"

namespace stria {
namespace {

constexpr std::size_t kLeastViewsOfAHalf = 4;
constexpr double kSeenByBoth = 0.02;  ///< least share of the information in either half
/// Modes are unit variances of the joint solution, priors included: this keeps the sums regular
/// where only a prior speaks.
constexpr double kFloor = 0.01;

Eigen::MatrixXd total(const std::vector<const ProjectedView*>& views) {
    Eigen::MatrixXd sum =
        Eigen::MatrixXd::Zero(views.front()->by_mode.cols(), views.front()->by_mode.cols());
    for (const ProjectedView* view : views) sum += view->information();
    return sum;
}

Eigen::MatrixXd scatter(const std::vector<const ProjectedView*>& views, const CornerNoise& noise,
                        double pitch_mm) {
    Eigen::MatrixXd sum =
        Eigen::MatrixXd::Zero(views.front()->by_mode.cols(), views.front()->by_mode.cols());
    for (const ProjectedView* view : views) sum += view->scatter(noise, pitch_mm);
    return sum;
}

Eigen::VectorXd gradient(const std::vector<const ProjectedView*>& views) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(views.front()->by_mode.cols());
    for (const ProjectedView* view : views) sum += view->gradient();
    return sum;
}

/// Halves by a number of each view: the lower and the upper ones.
template <typename Key>
SplitCheck split(const std::string& how, const std::vector<ProjectedView>& views, const Key& key,
                 const Eigen::MatrixXd& moves, const CornerNoise& noise, double pitch_mm) {
    std::vector<std::size_t> order(views.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return key(views[a]) < key(views[b]); });
    std::vector<const ProjectedView*> a, b;
    for (std::size_t i = 0; i < order.size(); ++i)
        (i < order.size() / 2 ? a : b).push_back(&views[order[i]]);
    SplitCheck check;
    check.how = how;
    check.views_a = static_cast<int>(a.size());
    check.views_b = static_cast<int>(b.size());
    if (a.size() < kLeastViewsOfAHalf) return check;
    check.done = true;

    // In the basis where the sum of both informations is 1 and a's is diagonal (lambda), a steps by
    // -g_a / lambda and b by -g_b / (1 - lambda); the gradients have their scatters as covariance.
    const Eigen::MatrixXd ha = total(a), hb = total(b);
    const Eigen::MatrixXd both = ha + hb + kFloor * Eigen::MatrixXd::Identity(ha.rows(), ha.cols());
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eigen(ha, both);
    const Eigen::VectorXd ga = eigen.eigenvectors().transpose() * gradient(a);
    const Eigen::VectorXd gb = eigen.eigenvectors().transpose() * gradient(b);
    const Eigen::VectorXd hb_own =
        (eigen.eigenvectors().transpose() * hb * eigen.eigenvectors()).diagonal();
    std::vector<Eigen::Index> seen;
    for (Eigen::Index k = 0; k < ga.size(); ++k)
        if (std::min(eigen.eigenvalues()[k], hb_own[k]) >= kSeenByBoth) seen.push_back(k);
    check.degrees = static_cast<int>(seen.size());
    if (seen.empty()) return check;
    const Eigen::MatrixXd basis = eigen.eigenvectors()(Eigen::all, seen);
    const Eigen::VectorXd step_a = eigen.eigenvalues()(seen).cwiseInverse();
    const Eigen::VectorXd step_b = hb_own(seen).cwiseInverse();
    const auto stepped = [&](const std::vector<const ProjectedView*>& half,
                             const Eigen::VectorXd& step) -> Eigen::MatrixXd {
        return step.asDiagonal() * (basis.transpose() * scatter(half, noise, pitch_mm) * basis) *
               step.asDiagonal();
    };
    const Eigen::VectorXd differs = gb(seen).cwiseProduct(step_b) - ga(seen).cwiseProduct(step_a);
    const Eigen::MatrixXd covariance = stepped(a, step_a) + stepped(b, step_b);
    check.chi_square = differs.dot(covariance.ldlt().solve(differs));
    check.p_value = chi_square_tail(check.chi_square, check.degrees);
    const Eigen::MatrixXd by_basis = moves * basis;
    const double points = static_cast<double>(moves.rows()) / 3;
    check.difference_mm = std::sqrt((by_basis * differs).squaredNorm() / points);
    check.expected_mm = std::sqrt((by_basis * covariance).cwiseProduct(by_basis).sum() / points);
    return check;
}

/// Sums over neighbouring rows of all views. A row's weight is how much of the shared error it
/// would show.
struct Neighbours {
    double products = 0, squares = 0, taken = 0, taken_squares = 0;
    double weight_squares = 0;  ///< over rows
    double pair_squares = 0;    ///< squared products of weights, over pairs
    std::size_t pairs = 0, rows = 0;

    WhitenessCheck judge(double unit) const {
        WhitenessCheck check;
        check.pairs = pairs;
        if (pairs == 0 || pair_squares <= 0) return check;
        const double left = static_cast<double>(rows) - taken_squares;  // degrees of freedom
        const double variance = squares / std::max(1.0, left);
        const double shared = products / variance + taken;  // expected: -taken
        check.correlation =
            shared / pair_squares * weight_squares / static_cast<double>(rows);  // of a usual row
        check.z = shared / std::sqrt(pair_squares);
        check.p_value = normal_tail(check.z);
        check.model_error = unit * std::sqrt(variance * std::max(0.0, check.correlation));
        return check;
    }
};

/// Residuals of one view after the joint correction, and the share of the fit in each pair.
class FittedView {
  public:
    FittedView(const ProjectedView& view, const Eigen::VectorXd& step,
               const Eigen::LDLT<Eigen::MatrixXd>& information)
        : view_(view),
          residual_(view.residual + view.by_mode * step),
          weighted_(information.solve(view.by_mode.transpose())) {}

    void add_row(Eigen::Index i, Neighbours& sums, double weight = 1) const {
        if (!use(i)) return;
        sums.squares += residual_[i] * residual_[i];
        sums.taken_squares += hat(i, i);
        sums.weight_squares += weight * weight;
        ++sums.rows;
    }
    /// @param weight  product of both rows' weights
    void add_pair(Eigen::Index i, Eigen::Index j, Neighbours& sums, double weight = 1) const {
        if (!use(i) || !use(j)) return;
        sums.products += weight * residual_[i] * residual_[j];
        sums.taken += weight * hat(i, j);
        sums.pair_squares += weight * weight;
        ++sums.pairs;
    }

  private:
    bool use(Eigen::Index i) const { return view_.use[static_cast<std::size_t>(i)] != 0; }
    double hat(Eigen::Index i, Eigen::Index j) const {
        return view_.pose_basis.row(i).dot(view_.pose_basis.row(j)) +
               view_.by_mode.row(i).dot(weighted_.col(j));
    }
    const ProjectedView& view_;
    Eigen::VectorXd residual_;
    Eigen::MatrixXd weighted_;
};

void add_corners(const FittedView& fitted, const ViewData& data, double spacing_mm,
                 Neighbours& sums) {
    const auto& corners = data.corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const auto row = 2 * static_cast<Eigen::Index>(i);
        for (int c = 0; c < 2; ++c) fitted.add_row(row + c, sums);
        for (std::size_t j = i + 1; j < corners.size() && corners[j].s == corners[i].s; ++j)
            if ((corners[i].on_board - corners[j].on_board).norm() < spacing_mm)
                for (int c = 0; c < 2; ++c)
                    fitted.add_pair(row + c, 2 * static_cast<Eigen::Index>(j) + c, sums);
    }
}

void add_stripes(const FittedView& fitted, const Channel& channel, const ViewData& data,
                 double board_area_mm2, Neighbours& sums) {
    const auto points = stripes_on_board(channel, data);
    if (points.empty()) return;
    const double near = 1.6 * std::sqrt(board_area_mm2 / static_cast<double>(points.size()));
    const auto first = 2 * static_cast<Eigen::Index>(data.corners.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        fitted.add_row(first + static_cast<Eigen::Index>(i), sums);
        for (std::size_t j = i + 1; j < points.size(); ++j)
            if ((points[i] - points[j]).norm() < near)
                fitted.add_pair(first + static_cast<Eigen::Index>(i),
                                first + static_cast<Eigen::Index>(j), sums);
    }
}

/// How far (sigmas) each stripe point would seem from the sheet per mm or rad that the axis is off.
std::vector<double> seen_of_axis(const Channel& channel, const ViewData& view) {
    const double step = channel.axis.kind == MachineKind::rail ? 1e-3 : 1e-5;
    std::vector<double> seen;
    for (const ViewData::Stripe& stripe : view.stripes) {
        const auto distance = [&](double s) {
            return distance_on_board(channel, view.camera_from_board, stripe.pixel, s,
                                     stripe.height_mm);
        };
        const double slope = (distance(stripe.s + step) - distance(stripe.s - step)) / (2 * step);
        seen.push_back(std::isfinite(slope) ? slope / stripe.sigma_mm : 0);
    }
    return seen;
}

/// Each point with the next two in the axis' order: as they are, and by what they see of the axis.
void add_stripes_by_axis(const FittedView& fitted, const Channel& channel, const ViewData& data,
                         Neighbours& sums, Neighbours& axis_run) {
    std::vector<std::size_t> order(data.stripes.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return data.stripes[a].s < data.stripes[b].s;
    });
    const auto seen = seen_of_axis(channel, data);
    const auto row = [&](std::size_t i) {
        return static_cast<Eigen::Index>(2 * data.corners.size() + i);
    };
    for (std::size_t i = 0; i < order.size(); ++i) {
        fitted.add_row(row(order[i]), sums);
        fitted.add_row(row(order[i]), axis_run, seen[order[i]]);
        for (std::size_t j = i + 1; j < std::min(i + 3, order.size()); ++j) {
            fitted.add_pair(row(order[i]), row(order[j]), sums);
            fitted.add_pair(row(order[i]), row(order[j]), axis_run,
                            seen[order[i]] * seen[order[j]]);
        }
    }
}

/// Rms sigma across the sheet of the stripe points in use.
double stripe_sigma_mm(const std::vector<ProjectedView>& views) {
    double squares = 0, count = 0;
    for (const ProjectedView& view : views)
        for (std::size_t i = 0; i < view.data.stripes.size(); ++i) {
            if (!view.use[2 * view.data.corners.size() + i]) continue;
            squares += view.data.stripes[i].sigma_mm * view.data.stripes[i].sigma_mm;
            ++count;
        }
    return count > 0 ? std::sqrt(squares / count) : 0;
}

}  // namespace

std::vector<VolumeSample> pulse_samples(const std::vector<CornerView>& views,
                                        const ScannerModel& model, std::size_t most) {
    std::size_t count = 0;
    for (const CornerView& view : views) count += view.pulses.pulses.size();
    const std::size_t every = std::max<std::size_t>(1, count / std::max<std::size_t>(1, most));
    std::vector<VolumeSample> samples;
    std::size_t next = 0;
    for (const CornerView& view : views)
        for (const Pulse& pulse : view.pulses.pulses) {
            if (next++ % every != every / 2 || pulse.flags != 0) continue;
            const Eigen::Vector2d pixel(pulse.u, pulse.v);
            if (triangulate(model.channels.front(), pixel, pulse.s))
                samples.push_back({pixel, pulse.s});
        }
    return samples;
}

CrossValidation cross_validate(const std::vector<CornerView>& views, const Board& board,
                               const ScannerCalibration& solved, int stripe_points_per_view) {
    const ScannerModel& model = solved.model;
    const Channel& channel = model.channels.front();
    const Board bent = with_warp(board, solved.board_warp_mm);
    const Eigen::MatrixXd modes = covariance_modes(model.covariance);
    std::vector<ProjectedView> projected;
    for (const CornerView& view : views) {
        ViewData data = measured_view(model, bent, view, solved.corner_sigma_px,
                                      solved.stripe_sigma_factor, stripe_points_per_view);
        if (!data.corners.empty())
            projected.push_back(projected_view(model, modes, std::move(data)));
    }
    CrossValidation result;
    if (projected.empty()) return result;

    const Eigen::MatrixXd moves = point_moves(model, modes, pulse_samples(views, model));
    const auto points = board_points(board);
    const Eigen::Vector3d middle = 0.5 * (points.front() + points.back());
    const auto place = [&](const ProjectedView& view) {
        return Eigen::Vector3d(board_motion(channel, view.data.corners.front().s) *
                               (view.data.camera_from_board * middle));
    };
    const auto add_split = [&](const std::string& how, const auto& key) {
        result.splits.push_back(
            split(how, projected, key, moves, solved.corner_noise, board.pitch_mm));
    };
    add_split("near and far", [&](const ProjectedView& v) { return place(v).z(); });
    add_split("inner and outer", [&](const ProjectedView& v) {
        const Eigen::Vector3d p = place(v);
        return p.head<2>().norm() / p.z();
    });

    std::vector<const ProjectedView*> all;
    for (const ProjectedView& view : projected) all.push_back(&view);
    const Eigen::MatrixXd sum = total(all);
    const Eigen::LDLT<Eigen::MatrixXd> information(
        sum + kFloor * Eigen::MatrixXd::Identity(sum.rows(), sum.cols()));
    const Eigen::VectorXd step = -information.solve(gradient(all));
    Neighbours corners, stripes, by_axis, axis_run;
    const double area = pattern_size_mm(board).prod();
    for (const ProjectedView& view : projected) {
        const FittedView fitted(view, step, information);
        add_corners(fitted, view.data, 1.5 * board.pitch_mm, corners);
        add_stripes(fitted, channel, view.data, area, stripes);
        add_stripes_by_axis(fitted, channel, view.data, by_axis, axis_run);
    }
    result.corners = corners.judge(solved.corner_sigma_px);
    result.stripes = stripes.judge(1);
    result.stripes_by_axis = by_axis.judge(1);
    result.axis_run = axis_run.judge(1);
    result.stripe_sigma_mm = stripe_sigma_mm(projected);

    double least = 1;
    const auto count = [&](double p) {
        least = std::min(least, p);
        ++result.tests;
    };
    for (const SplitCheck& check : result.splits)
        if (check.done) count(check.p_value);
    for (const WhitenessCheck* check :
         {&result.corners, &result.stripes, &result.stripes_by_axis, &result.axis_run})
        if (check->pairs > 0) count(check->p_value);
    result.p_value = std::min(1.0, result.tests * least);
    return result;
}

}  // namespace stria
