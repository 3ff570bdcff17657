#include "host/registration/joint.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "firmware/core/median.h"
#include "host/geometry/parallel.h"
#include "host/registration/joint_problem.h"

namespace stria {
namespace {

using Eigen::Vector3d;

constexpr double kMadToSigma = 1.4826;
constexpr double kTukey = 4.685;  // 95 % efficient for normal noise
constexpr double kAnneal = 0.7;   // a step's share of the one before

/// Sampling of the levels: a few points far off, then all.
struct Level {
    std::size_t samples;
    double tolerance_mm;
};

class JointSolver {
  public:
    JointSolver(const SurfaceList& surfaces, const std::vector<ScanPose>& initial,
                const JointOptions& options);
    JointResult solve();

  private:
    void make_pairs();
    void associate();
    void choose_samples(std::size_t count);
    void narrow_gates();
    void weigh(PairMatches& pair) const;
    JointStep step(int level);
    void report(JointResult& result) const;
    double match_sigma(const PairMatches& pair, const Match& match) const;

    const SurfaceList& surfaces_;
    const JointOptions options_;
    std::vector<Rigid3> poses_;
    JointProblem problem_;
    std::vector<PairMatches> pairs_;
    std::vector<std::vector<std::uint32_t>> samples_;  ///< of each scan, at the level at hand
    double start_distance_ = 0;
    double tolerance_ = 0;
    double anneal_mm_ = 0;  ///< least spread of any pair for now; 0: each has its own
    double least_anneal_mm_ = 0;
    bool use_sigma_ = true;
};

JointSolver::JointSolver(const SurfaceList& surfaces, const std::vector<ScanPose>& initial,
                         const JointOptions& options)
    : surfaces_(surfaces), options_(options), problem_{surfaces_, poses_,           {},
                                                       0,         Vector3d::Zero(), 1.0} {
    bool any_fixed = false;
    for (const ScanPose& pose : initial) {
        poses_.push_back(pose.world_from_scan);
        any_fixed = any_fixed || pose.fixed;
    }
    std::vector<double> extents, pitches;
    double count = 0;
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        const bool fixed = any_fixed ? initial[i].fixed : i == 0;
        problem_.block.push_back(fixed ? -1 : problem_.unknowns);
        if (!fixed) problem_.unknowns += 6;
        use_sigma_ = use_sigma_ && (surfaces[i]->points.empty() || !surfaces[i]->sigma_mm.empty());
        if (surfaces[i]->points.empty()) continue;
        extents.push_back(2 * surfaces[i]->radius_mm());
        pitches.push_back(surfaces[i]->pitch_mm);
        problem_.centre += poses_[i] * surfaces[i]->centre;
        count += 1;
    }
    if (count > 0) problem_.centre /= count;
    problem_.scale_mm = std::max(1e-9, 0.25 * median(extents));  // a typical arm
    start_distance_ =
        options.start_distance_mm > 0 ? options.start_distance_mm : 0.1 * median(extents);
    anneal_mm_ = start_distance_ / kTukey;
    least_anneal_mm_ = 0.25 * median(pitches);
    tolerance_ = options.tolerance_mm > 0 ? options.tolerance_mm : median(pitches) / 500;
    make_pairs();
}

void JointSolver::make_pairs() {
    for (std::size_t i = 0; i < surfaces_.size(); ++i)
        for (std::size_t j = 0; j < surfaces_.size(); ++j) {
            if (i == j || (problem_.block[i] < 0 && problem_.block[j] < 0)) continue;
            PairMatches pair;
            pair.source = i;
            pair.target = j;
            pair.gate_mm = start_distance_;
            pairs_.push_back(std::move(pair));
        }
}

/// Standard deviation of a match's distance: both points' noise.
double JointSolver::match_sigma(const PairMatches& pair, const Match& match) const {
    if (!use_sigma_) return 1.0;
    return std::max(1e-6, std::hypot(surfaces_[pair.source]->sigma_mm[match.source],
                                     surfaces_[pair.target]->sigma_mm[match.target]));
}

void JointSolver::choose_samples(std::size_t count) {
    samples_.clear();
    for (const ScanSurface* surface : surfaces_)
        samples_.push_back(ordered_samples(*surface, count));
    for (PairMatches& pair : pairs_) pair.warm.clear();
}

void JointSolver::associate() {
    const double cosine = std::cos(options_.max_normal_angle_rad);
    parallel_for_blocks(pairs_.size(), 1, [&](std::size_t begin, std::size_t) {
        PairMatches& pair = pairs_[begin];
        const Rigid3 target_from_source = poses_[pair.target].inverse() * poses_[pair.source];
        pair.matches =
            find_matches(*surfaces_[pair.source], *surfaces_[pair.target], target_from_source,
                         {.max_distance_mm = pair.gate_mm, .min_normal_cosine = cosine},
                         samples_[pair.source], pair.warm);
        pair.residual_mm.clear();
        pair.sigma_mm.clear();
        pair.distance_mm.clear();
        for (const Match& match : pair.matches) {
            pair.residual_mm.push_back(plane_distance(
                *surfaces_[pair.source], *surfaces_[pair.target], target_from_source, match));
            pair.sigma_mm.push_back(match_sigma(pair, match));
            pair.distance_mm.push_back(
                (target_from_source * surfaces_[pair.source]->points[match.source] -
                 surfaces_[pair.target]->points[match.target])
                    .norm());
        }
        weigh(pair);
    });
}

/// Tukey weights about the pair's own spread; and the gate of its next association, which follows
/// the distances found, never below three pitches.
void JointSolver::weigh(PairMatches& pair) const {
    pair.weight.assign(pair.matches.size(), 0.0);
    if (pair.matches.size() < static_cast<std::size_t>(options_.min_matches)) return;
    std::vector<double> sizes;
    for (std::size_t m = 0; m < pair.matches.size(); ++m)
        sizes.push_back(std::abs(pair.residual_mm[m]) / pair.sigma_mm[m]);
    // With sigmas the noise alone sets the least spread; without, a thousandth of the pitch does.
    const double least = use_sigma_ ? 1.0 : 1e-3 * surfaces_[pair.target]->pitch_mm;
    // Early on no pair may be surer than the anneal allows: most of a smooth part agrees with
    // itself wherever it slides to, and the few places that tell where it belongs would count as
    // outliers.
    const double annealed = anneal_mm_ / median(pair.sigma_mm);
    pair.spread = std::max({least, kMadToSigma * median(sizes), annealed});
    for (std::size_t m = 0; m < pair.matches.size(); ++m) {
        const double u = sizes[m] / (kTukey * pair.spread);
        if (u >= 1) continue;
        const double scale = pair.spread * pair.sigma_mm[m];
        pair.weight[m] = std::pow(1 - u * u, 2) / (scale * scale);
    }
    const double pitch =
        std::max(surfaces_[pair.source]->pitch_mm, surfaces_[pair.target]->pitch_mm);
    pair.gate_mm = std::min(
        pair.gate_mm, std::max({3 * pitch, 4 * median(pair.distance_mm), kTukey * anneal_mm_}));
}

/// Poses that have settled are good to the distances most matches show; pairs that barely overlap
/// must not go on matching what lies farther apart than that.
void JointSolver::narrow_gates() {
    std::vector<double> distances, pitches;
    for (const PairMatches& pair : pairs_)
        for (std::size_t m = 0; m < pair.matches.size(); ++m)
            if (pair.weight[m] > 0) distances.push_back(pair.distance_mm[m]);
    for (const ScanSurface* surface : surfaces_)
        if (!surface->points.empty()) pitches.push_back(surface->pitch_mm);
    const double gate = std::max(3 * median(pitches), 4 * median(distances));
    for (PairMatches& pair : pairs_) pair.gate_mm = std::min(pair.gate_mm, gate);
}

JointStep JointSolver::step(int level) {
    JointStep result;
    result.level = level;
    double sum = 0, weight = 0;
    for (const PairMatches& pair : pairs_)
        for (std::size_t m = 0; m < pair.matches.size(); ++m) {
            sum += pair.weight[m] * pair.residual_mm[m] * pair.residual_mm[m];
            weight += pair.weight[m];
            result.matches += pair.weight[m] > 0;
        }
    result.rms_mm = weight > 0 ? std::sqrt(sum / weight) : 0;
    const Eigen::VectorXd unknowns = solve_step(build_equations(problem_, pairs_));
    for (std::size_t i = 0; i < poses_.size(); ++i) {
        if (problem_.block[i] < 0) continue;
        const Vector6d mine = unknowns.segment<6>(problem_.block[i]);
        const Rigid3 motion = motion_of_step(problem_, mine);
        const Vector3d centre = poses_[i] * surfaces_[i]->centre;
        const double turn = mine.head<3>().norm() / problem_.scale_mm;
        result.largest_move_mm =
            std::max(result.largest_move_mm,
                     (motion * centre - centre).norm() + turn * surfaces_[i]->radius_mm());
        poses_[i] = motion * poses_[i];
        poses_[i].rotation = nearest_rotation(poses_[i].rotation);
    }
    return result;
}

void JointSolver::report(JointResult& result) const {
    result.scans.resize(poses_.size());
    for (std::size_t i = 0; i < poses_.size(); ++i) {
        result.scans[i].world_from_scan = poses_[i];
        result.scans[i].fixed = problem_.block[i] < 0;
    }
    for (const PairMatches& pair : pairs_)
        for (const double weight : pair.weight)
            if (weight > 0) {
                ++result.scans[pair.source].matches;
                ++result.scans[pair.target].matches;
            }
    fill_covariance(problem_, pairs_, result.scans);
    result.overlap_rms_mm =
        overlap_rms_mm(surfaces_, poses_, static_cast<std::size_t>(options_.samples_per_scan));
    if (!result.converged)
        result.reason =
            "still moving by " +
            std::to_string(result.history.empty() ? 0.0 : result.history.back().largest_move_mm) +
            " mm after " + std::to_string(result.iterations) + " steps";
    for (std::size_t i = 0; i < result.scans.size(); ++i) {
        const JointScan& scan = result.scans[i];
        if (scan.fixed || scan.open_directions == 0) continue;
        result.converged = false;
        result.reason =
            "scan " + std::to_string(i) +
            (scan.matches == 0 ? " has no overlap with the others"
                               : ": the overlap leaves " + std::to_string(scan.open_directions) +
                                     " of 6 directions open");
        return;
    }
}

JointResult JointSolver::solve() {
    JointResult result;
    const auto all = static_cast<std::size_t>(options_.samples_per_scan);
    const std::vector<Level> levels = {{std::min<std::size_t>(all, 2000), 20 * tolerance_},
                                       {std::min<std::size_t>(all, 8000), 5 * tolerance_},
                                       {all, tolerance_}};
    for (std::size_t level = 0; level < levels.size(); ++level) {
        bool settled = false;
        if (level > 0) narrow_gates();
        choose_samples(levels[level].samples);
        while (!settled && result.iterations < options_.max_iterations) {
            associate();
            const JointStep done = step(static_cast<int>(level));
            result.history.push_back(done);
            ++result.iterations;
            settled = done.largest_move_mm < levels[level].tolerance_mm && anneal_mm_ == 0;
            anneal_mm_ = anneal_mm_ > least_anneal_mm_ ? kAnneal * anneal_mm_ : 0;
        }
        result.converged = settled;
    }
    associate();
    report(result);
    return result;
}

}  // namespace

std::string validate(const JointOptions& options) {
    const auto bad = [](const char* field, double value, const char* bound) {
        return std::string("JointOptions: ") + field + " = " + std::to_string(value) +
               ", expected " + bound;
    };
    if (!(options.start_distance_mm >= 0))
        return bad("start_distance_mm", options.start_distance_mm, ">= 0");
    if (!(options.max_normal_angle_rad > 0 && options.max_normal_angle_rad < 1.5708))
        return bad("max_normal_angle_rad", options.max_normal_angle_rad, "in (0, pi / 2)");
    if (options.samples_per_scan < 100)
        return bad("samples_per_scan", options.samples_per_scan, ">= 100");
    if (options.max_iterations < 1) return bad("max_iterations", options.max_iterations, ">= 1");
    if (!(options.tolerance_mm >= 0)) return bad("tolerance_mm", options.tolerance_mm, ">= 0");
    if (options.min_matches < 6) return bad("min_matches", options.min_matches, ">= 6");
    return {};
}

JointResult register_jointly(const SurfaceList& surfaces, const std::vector<ScanPose>& initial,
                             const JointOptions& options) {
    if (const std::string wrong = validate(options); !wrong.empty())
        throw std::invalid_argument(wrong);
    if (surfaces.size() != initial.size())
        throw std::invalid_argument("register_jointly: " + std::to_string(surfaces.size()) +
                                    " scans, " + std::to_string(initial.size()) + " poses");
    for (const ScanPose& pose : initial)
        if (!is_rigid(pose.world_from_scan))
            throw std::invalid_argument("register_jointly: the pose of '" + pose.file +
                                        "' is not a rigid motion");
    if (surfaces.empty()) {
        JointResult result;
        result.reason = "no scans";
        return result;
    }
    return JointSolver(surfaces, initial, options).solve();
}

JointResult register_jointly(const std::vector<ScanSurface>& surfaces,
                             const std::vector<ScanPose>& initial, const JointOptions& options) {
    return register_jointly(list_of(surfaces), initial, options);
}

}  // namespace stria
