#include "host/registration/joint_problem.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "host/geometry/parallel.h"

namespace stria {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Up to this many unknowns directions are told apart exactly, by eigenvalues.
constexpr Eigen::Index kMaxEigen = 600;
/// Eigenvalues below this share of the largest are rounding.
constexpr double kRounding = 1e-9;

/// A determined direction has this many times the feigned information.
constexpr double kPlain = 3.0;

struct PairSum {
    Matrix6d matrix = Matrix6d::Zero();
    Vector6d gradient = Vector6d::Zero();
    Matrix6d feigned = Matrix6d::Zero();
};

Eigen::Matrix3d cross_matrix(const Vector3d& v) {
    Eigen::Matrix3d cross;
    cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return cross;
}

PairSum sum_of(const JointProblem& problem, const PairMatches& pair) {
    PairSum sum;
    double weight_sum = 0, normal_scatter = 0;
    const Rigid3& source_pose = problem.poses[pair.source];
    for (std::size_t m = 0; m < pair.matches.size(); ++m) {
        const double weight = pair.weight[m];
        if (weight <= 0) continue;
        const Match& match = pair.matches[m];
        const Vector6d row = problem.row(pair, match);
        sum.matrix += weight * row * row.transpose();
        sum.gradient += weight * pair.residual_mm[m] * row;
        // A normal that errs by a tangential d makes up the row (arm x d, d).
        const Vector3d normal = row.tail<3>();
        const Vector3d arm = problem.arm(pair, match) / problem.scale_mm;
        Eigen::Matrix<double, 6, 3> lever;
        lever << cross_matrix(arm), Eigen::Matrix3d::Identity();
        const Eigen::Matrix<double, 6, 3> tangential =
            lever - (lever * normal) * normal.transpose();
        sum.feigned += weight * tangential * tangential.transpose();
        const Vector3d other =
            source_pose.rotation * problem.surfaces[pair.source]->normals[match.source];
        weight_sum += weight;
        normal_scatter += weight * normal.cross(other).squaredNorm();
    }
    // The squared sine between two normals holds two errors in two directions each.
    if (weight_sum > 0) sum.feigned *= 0.25 * normal_scatter / weight_sum;
    return sum;
}

/// Directions v with their information as a multiple of the feigned one; v' feigned v = 1.
struct Directions {
    VectorXd multiples;
    MatrixXd vectors;
};

Directions directions_of(const NormalEquations& equations) {
    MatrixXd feigned = equations.feigned;
    const double largest = equations.matrix.diagonal().maxCoeff();
    feigned.diagonal().array() += std::max(kRounding * largest, 1e-300);
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(equations.matrix, feigned);
    return {solver.eigenvalues(), solver.eigenvectors()};
}

/// A match's share of the gradient's change with the noise of one point.
struct Share {
    std::uint32_t point;
    std::uint32_t pair;
    std::uint32_t match;
    bool is_source;
};

/// Sum over a scan's points of (its noise's effect on the gradient) squared: the meat of the
/// sandwich. One point's noise enters every match that uses the point, so those add up first.
MatrixXd noise_of_scan(const JointProblem& problem, const std::vector<PairMatches>& pairs,
                       std::size_t scan) {
    std::vector<Share> shares;
    for (std::size_t p = 0; p < pairs.size(); ++p) {
        const bool is_source = pairs[p].source == scan;
        if (!is_source && pairs[p].target != scan) continue;
        for (std::size_t m = 0; m < pairs[p].matches.size(); ++m)
            if (pairs[p].weight[m] > 0)
                shares.push_back(
                    {is_source ? pairs[p].matches[m].source : pairs[p].matches[m].target,
                     static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(m), is_source});
    }
    std::stable_sort(shares.begin(), shares.end(),
                     [](const Share& a, const Share& b) { return a.point < b.point; });

    MatrixXd meat = MatrixXd::Zero(problem.unknowns, problem.unknowns);
    const ScanSurface& surface = *problem.surfaces[scan];
    std::vector<std::pair<int, Vector6d>> effect;  // by block
    const auto add = [&](std::size_t of, const Vector6d& value) {
        if (problem.block[of] < 0) return;
        for (auto& [block, sum] : effect)
            if (block == problem.block[of]) {
                sum += value;
                return;
            }
        effect.emplace_back(problem.block[of], value);
    };
    for (std::size_t begin = 0; begin < shares.size();) {
        effect.clear();
        std::size_t end = begin;
        for (; end < shares.size() && shares[end].point == shares[begin].point; ++end) {
            const PairMatches& pair = pairs[shares[end].pair];
            const std::size_t m = shares[end].match;
            const double sigma = surface.sigma_mm.empty() ? pair.spread * pair.sigma_mm[m] /
                                                                std::sqrt(2.0)  // half each point's
                                                          : surface.sigma_mm[shares[end].point];
            const double sign = shares[end].is_source ? 1.0 : -1.0;
            const Vector6d value =
                sign * sigma * pair.weight[m] * problem.row(pair, pair.matches[m]);
            add(pair.source, value);
            add(pair.target, -value);
        }
        for (const auto& [a, va] : effect)
            for (const auto& [b, vb] : effect) meat.block<6, 6>(a, b) += va * vb.transpose();
        begin = end;
    }
    return meat;
}

/// Rotation (rad) and translation at the world's origin, from a step's unknowns.
Matrix6d world_from_step(const JointProblem& problem) {
    Matrix6d map = Matrix6d::Zero();
    map.topLeftCorner<3, 3>() = Eigen::Matrix3d::Identity() / problem.scale_mm;
    map.bottomRightCorner<3, 3>().setIdentity();
    // t_world = t + centre x rotation
    map.bottomLeftCorner<3, 3>() = cross_matrix(problem.centre) / problem.scale_mm;
    return map;
}

/// Share of each scan's six unknowns that lies in open directions, rounded to whole ones.
std::vector<int> open_directions(const JointProblem& problem, const Directions& directions) {
    Eigen::Index count = 0;
    while (count < directions.multiples.size() && directions.multiples(count) <= kPlain) ++count;
    std::vector<int> open(problem.block.size(), 0);
    if (count == 0) return open;
    const MatrixXd basis =
        Eigen::HouseholderQR<MatrixXd>(directions.vectors.leftCols(count)).householderQ() *
        MatrixXd::Identity(problem.unknowns, count);
    for (std::size_t i = 0; i < open.size(); ++i) {
        if (problem.block[i] < 0) continue;
        const double share = basis.middleRows(problem.block[i], 6).squaredNorm();
        open[i] = share > 1e-3 ? std::max(1, static_cast<int>(std::lround(share))) : 0;
    }
    return open;
}

}  // namespace

Vector6d JointProblem::row(const PairMatches& pair, const Match& match) const {
    const Vector3d normal =
        poses[pair.target].rotation * surfaces[pair.target]->normals[match.target];
    Vector6d row;
    row << arm(pair, match).cross(normal) / scale_mm, normal;
    return row;
}

Vector3d JointProblem::arm(const PairMatches& pair, const Match& match) const {
    return poses[pair.source] * surfaces[pair.source]->points[match.source] - centre;
}

NormalEquations build_equations(const JointProblem& problem,
                                const std::vector<PairMatches>& pairs) {
    std::vector<PairSum> sums(pairs.size());
    parallel_for_blocks(pairs.size(), 1, [&](std::size_t begin, std::size_t) {
        sums[begin] = sum_of(problem, pairs[begin]);
    });
    const MatrixXd zero = MatrixXd::Zero(problem.unknowns, problem.unknowns);
    NormalEquations equations{zero, VectorXd::Zero(problem.unknowns), zero};
    const auto add = [](MatrixXd& to, int a, int b, const Matrix6d& part) {
        if (a >= 0) to.block<6, 6>(a, a) += part;
        if (b >= 0) to.block<6, 6>(b, b) += part;
        if (a >= 0 && b >= 0) {
            to.block<6, 6>(a, b) -= part;
            to.block<6, 6>(b, a) -= part;
        }
    };
    for (std::size_t p = 0; p < pairs.size(); ++p) {
        const int a = problem.block[pairs[p].source], b = problem.block[pairs[p].target];
        add(equations.matrix, a, b, sums[p].matrix);
        add(equations.feigned, a, b, sums[p].feigned);
        if (a >= 0) equations.gradient.segment<6>(a) += sums[p].gradient;
        if (b >= 0) equations.gradient.segment<6>(b) -= sums[p].gradient;
    }
    return equations;
}

VectorXd solve_step(const NormalEquations& equations) {
    const Eigen::Index size = equations.matrix.rows();
    if (size == 0) return {};
    if (size > kMaxEigen) {  // weak directions are held back rather than told apart
        MatrixXd damped = equations.matrix + equations.feigned;
        damped.diagonal().array() += std::max(kRounding * damped.diagonal().maxCoeff(), 1e-300);
        return damped.llt().solve(-equations.gradient);
    }
    const Directions directions = directions_of(equations);
    VectorXd along = directions.vectors.transpose() * -equations.gradient;
    for (Eigen::Index k = 0; k < size; ++k) {
        const double multiple = directions.multiples(k);
        along(k) = multiple > kPlain ? along(k) / multiple : 0;
    }
    return directions.vectors * along;
}

Rigid3 motion_of_step(const JointProblem& problem, const Vector6d& step) {
    const Eigen::Matrix3d rotation = rotation_from_vector(step.head<3>() / problem.scale_mm);
    return {rotation, problem.centre - rotation * problem.centre + step.tail<3>()};
}

void fill_covariance(const JointProblem& problem, const std::vector<PairMatches>& pairs,
                     std::vector<JointScan>& scans) {
    if (problem.unknowns == 0) return;
    const NormalEquations equations = build_equations(problem, pairs);
    const Directions directions = directions_of(equations);
    std::vector<MatrixXd> parts(scans.size());
    parallel_for_blocks(scans.size(), 1, [&](std::size_t begin, std::size_t) {
        parts[begin] = noise_of_scan(problem, pairs, begin);
    });
    MatrixXd meat = MatrixXd::Zero(problem.unknowns, problem.unknowns);
    for (const MatrixXd& part : parts) meat += part;

    VectorXd inverse(problem.unknowns);
    for (Eigen::Index k = 0; k < inverse.size(); ++k)
        inverse(k) = directions.multiples(k) > kPlain ? 1.0 / directions.multiples(k) : 0.0;
    const MatrixXd bread =
        directions.vectors * inverse.asDiagonal() * directions.vectors.transpose();
    const MatrixXd covariance = bread * meat * bread;
    const Matrix6d map = world_from_step(problem);
    const std::vector<int> open = open_directions(problem, directions);
    for (std::size_t i = 0; i < scans.size(); ++i) {
        const int block = problem.block[i];
        if (block < 0) continue;
        JointScan& scan = scans[i];
        scan.covariance = map * covariance.block<6, 6>(block, block) * map.transpose();
        scan.open_directions = open[i];
        const Vector3d at = scan.world_from_scan * problem.surfaces[i]->centre;
        Eigen::Matrix<double, 3, 6> displacement;  // rotation x at + translation
        displacement << -cross_matrix(at), Eigen::Matrix3d::Identity();
        const Eigen::Matrix3d at_centre = displacement * scan.covariance * displacement.transpose();
        scan.sigma_rad = std::sqrt(scan.covariance.topLeftCorner<3, 3>().trace());
        scan.sigma_mm = std::sqrt(at_centre.trace());
        if (scan.open_directions > 0)
            scan.sigma_rad = scan.sigma_mm = std::numeric_limits<double>::infinity();
    }
}

}  // namespace stria
