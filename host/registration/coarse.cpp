#include "host/registration/coarse.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "firmware/core/median.h"
#include "host/geometry/parallel.h"
#include "host/registration/joint.h"
#include "host/registration/pair_check.h"
#include "host/registration/pairwise.h"
#include "host/registration/pose_hypotheses.h"
#include "host/registration/shape_features.h"

namespace stria {
namespace {

using Eigen::Vector3d;
constexpr int kHypotheses = 100;     ///< poses of a pair that get a quick look
constexpr int kSecondChance = 6;     ///< times as many are tried where scans stay apart
constexpr std::size_t kKeys = 1500;  ///< points of a scan that are compared

/// Of the registration of thinned scans: wide enough for a rough pose, quick, and no finer than the
/// thinned points are.
JointOptions thin_options(double detail_mm) {
    return {.start_distance_mm = 5 * detail_mm,
            .samples_per_scan = 1500,
            .max_iterations = 40,
            .tolerance_mm = 0.01 * detail_mm};
}

/// Joins pairs to groups, best first.
class Assembly {
  public:
    Assembly(const std::vector<CheckedScan>& scans, const CoarseOptions& options, double detail_mm)
        : scans_(scans),
          options_(options),
          detail_(detail_mm),
          group_(scans.size()),
          pose_(scans.size()) {
        for (std::size_t i = 0; i < group_.size(); ++i) group_[i] = i;
    }

    /// True if the pair joined two groups.
    bool join(const CoarsePair& pair);
    std::vector<std::size_t> largest_group() const;
    /// Pairs of scans that are not in one group.
    std::vector<std::pair<std::size_t, std::size_t>> pairs_apart() const;
    const Rigid3& pose(std::size_t scan) const { return pose_[scan]; }

  private:
    std::vector<std::size_t> members(std::size_t group) const;
    /// With more than `share` times what is allowed.
    bool is_contradicted(const std::vector<std::size_t>& staying,
                         const std::vector<std::size_t>& moving, double share,
                         double free_mm) const;
    void refine(const std::vector<std::size_t>& all);

    const std::vector<CheckedScan>& scans_;
    const CoarseOptions& options_;
    double detail_;
    std::vector<std::size_t> group_;  ///< of each scan: the number of its first member
    std::vector<Rigid3> pose_;        ///< group_from_scan
};

std::vector<std::size_t> Assembly::members(std::size_t group) const {
    std::vector<std::size_t> list;
    for (std::size_t i = 0; i < group_.size(); ++i)
        if (group_[i] == group) list.push_back(i);
    return list;
}

bool Assembly::is_contradicted(const std::vector<std::size_t>& staying,
                               const std::vector<std::size_t>& moving, double share,
                               double free_mm) const {
    for (const std::size_t a : moving)
        for (const std::size_t b : staying) {
            const PairCheck check = check_pair(scans_[a], scans_[b], pose_[b].inverse() * pose_[a],
                                               {0.5 * detail_, free_mm, 1});
            if (check.contradiction > share * options_.max_contradiction ||
                check.missing > share * options_.max_missing)
                return true;
            if (share <= 1 && check.overlap > options_.min_overlap &&
                check.looseness > options_.max_looseness)
                return true;
        }
    return false;
}

bool Assembly::join(const CoarsePair& pair) {
    if (group_[pair.source] == group_[pair.target]) return false;
    const auto staying = members(group_[pair.target]), moving = members(group_[pair.source]);
    const std::vector<Rigid3> before = pose_;
    const Rigid3 motion =
        pose_[pair.target] * pair.target_from_source * pose_[pair.source].inverse();
    std::vector<std::size_t> all = staying;
    for (const std::size_t i : moving) {
        pose_[i] = motion * pose_[i];
        all.push_back(i);
    }
    // Errors add up along the chain that joins two scans: gross contradictions first, then all
    // pairs of the group pull it straight, and then it must hold as strictly as a pair does.
    bool fits = !is_contradicted(staying, moving, 3, 4 * detail_);
    if (fits && all.size() > 2) {
        refine(all);
        fits = !is_contradicted(staying, moving, 1, 1.5 * detail_);
    }
    if (!fits) {
        pose_ = before;
        return false;
    }
    const std::size_t number = std::min(group_[pair.source], group_[pair.target]);
    for (const std::size_t i : all) group_[i] = number;
    return true;
}

void Assembly::refine(const std::vector<std::size_t>& all) {
    SurfaceList surfaces;
    std::vector<ScanPose> poses;
    for (const std::size_t i : all) {
        surfaces.push_back(&scans_[i].thin);
        poses.emplace_back();
        poses.back().world_from_scan = pose_[i];
    }
    const JointResult result = register_jointly(surfaces, poses, thin_options(detail_));
    for (std::size_t k = 0; k < all.size(); ++k) pose_[all[k]] = result.scans[k].world_from_scan;
}

std::vector<std::size_t> Assembly::largest_group() const {
    std::vector<std::size_t> best;
    for (std::size_t group = 0; group < group_.size(); ++group)
        if (const auto list = members(group); list.size() > best.size()) best = list;
    return best;
}

std::vector<std::pair<std::size_t, std::size_t>> Assembly::pairs_apart() const {
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    for (std::size_t i = 0; i < group_.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (group_[i] != group_[j]) pairs.emplace_back(i, j);
    return pairs;
}

double detail_of(const std::vector<ScanSurface>& surfaces, const CoarseOptions& options) {
    if (options.detail_mm > 0) return options.detail_mm;
    std::vector<double> extents;
    double pitch = 0;
    for (const ScanSurface& surface : surfaces) {
        if (surface.points.empty()) continue;
        extents.push_back(2 * surface.radius_mm());
        pitch = std::max(pitch, surface.pitch_mm);
    }
    if (extents.empty()) return 0;
    return std::max(2 * pitch, median(std::move(extents)) / 130);
}

/// Of the many poses that some shapes suggest, those under which the scans look most like one part:
/// a quick look at some hundred points, with room for the poses being rough. Ranks first to last.
std::vector<Rigid3> most_plausible(const CheckedScan& from, const CheckedScan& to,
                                   const std::vector<PoseHypothesis>& hypotheses, double detail,
                                   std::size_t first, std::size_t last) {
    constexpr std::size_t kLooks = 400;
    const std::size_t smaller = std::min(from.thin.points.size(), to.thin.points.size());
    const PairTolerance rough = {2 * detail, 4 * detail,
                                 std::max<std::size_t>(1, smaller / kLooks)};
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t k = 0; k < hypotheses.size(); ++k) {
        const PairCheck check = check_pair(from, to, hypotheses[k].target_from_source, rough);
        order.emplace_back(4 * check.contradiction + check.missing - check.overlap, k);
    }
    std::sort(order.begin(), order.end());
    std::vector<Rigid3> poses;
    for (std::size_t i = first; i < std::min(last, order.size()); ++i)
        poses.push_back(hypotheses[order[i].second].target_from_source);
    return poses;
}

/// Looks for the poses of pairs of scans.
class PairSearch {
  public:
    using Pair = std::pair<std::size_t, std::size_t>;  ///< source, target

    PairSearch(const std::vector<CheckedScan>& scans, double detail_mm,
               const CoarseOptions& options);

    /// Verified poses of these pairs, from the plausible ones of rank `first` to before `last`.
    std::vector<CoarsePair> poses(const std::vector<Pair>& pairs, std::size_t first,
                                  std::size_t last) const;

  private:
    std::vector<CoarsePair> poses_of(const Pair& pair, std::size_t first, std::size_t last) const;
    std::optional<CoarsePair> verified(const Pair& pair, const Rigid3& start) const;

    const std::vector<CheckedScan>& scans_;
    double detail_;
    const CoarseOptions& options_;
    std::vector<Eigen::MatrixXf> features_;
    std::vector<std::vector<std::uint32_t>> points_;  ///< of each scan that are compared
    std::vector<ShapeKeys> keys_;                     ///< refer to the two above
};

PairSearch::PairSearch(const std::vector<CheckedScan>& scans, double detail_mm,
                       const CoarseOptions& options)
    : scans_(scans), detail_(detail_mm), options_(options), features_(scans.size()) {
    for (std::size_t i = 0; i < scans.size(); ++i)
        features_[i] = shape_features(scans[i].thin, 5 * detail_, 10 * detail_);
    std::vector<const ScanSurface*> surfaces;
    for (const CheckedScan& scan : scans) surfaces.push_back(&scan.thin);
    points_ = distinctive_points(surfaces, features_, kKeys);
    for (std::size_t i = 0; i < scans.size(); ++i)
        keys_.push_back({scans[i].thin, features_[i], points_[i]});
}

std::optional<CoarsePair> PairSearch::verified(const Pair& pair, const Rigid3& start) const {
    const CheckedScan &from = scans_[pair.first], &to = scans_[pair.second];
    const PairResult refined = register_pair(from.thin, to.thin, start, thin_options(detail_));
    if (refined.matches == 0) return std::nullopt;
    const PairCheck check =
        check_pair(from, to, refined.target_from_source, {0.5 * detail_, 1.5 * detail_, 1});
    if (check.overlap < options_.min_overlap || check.contradiction > options_.max_contradiction ||
        check.missing > options_.max_missing || check.looseness > options_.max_looseness)
        return std::nullopt;
    CoarsePair found;
    found.source = pair.first;
    found.target = pair.second;
    found.target_from_source = refined.target_from_source;
    found.overlap = check.overlap;
    found.contradiction = check.contradiction;
    found.rms_mm = check.rms_mm;
    found.missing = check.missing;
    found.score = check.agreeing * (1 - check.contradiction / options_.max_contradiction) *
                  (1 - check.missing / options_.max_missing) *
                  std::pow(1 - check.looseness / options_.max_looseness, 2);
    return found;
}

std::vector<CoarsePair> PairSearch::poses_of(const Pair& pair, std::size_t first,
                                             std::size_t last) const {
    const CheckedScan &from = scans_[pair.first], &to = scans_[pair.second];
    const std::vector<PoseHypothesis> hypotheses =
        pose_hypotheses(keys_[pair.first], keys_[pair.second], detail_, kHypotheses);
    std::vector<CoarsePair> found;
    for (const Rigid3& start : most_plausible(from, to, hypotheses, detail_, first, last)) {
        const auto pose = verified(pair, start);
        if (!pose) continue;
        const Vector3d centre = pose->target_from_source * from.thin.centre;
        const bool known = std::any_of(found.begin(), found.end(), [&](const CoarsePair& other) {
            const Rigid3 step = other.target_from_source * pose->target_from_source.inverse();
            return vector_from_rotation(step.rotation).norm() < 0.02 &&
                   (step * centre - centre).norm() < detail_;
        });
        if (!known) found.push_back(*pose);
    }
    return found;
}

std::vector<CoarsePair> PairSearch::poses(const std::vector<Pair>& pairs, std::size_t first,
                                          std::size_t last) const {
    std::vector<std::vector<CoarsePair>> found(pairs.size());
    parallel_for_blocks(pairs.size(), 1, [&](std::size_t i, std::size_t) {
        found[i] = poses_of(pairs[i], first, last);
    });
    std::vector<CoarsePair> all;
    for (const auto& list : found) all.insert(all.end(), list.begin(), list.end());
    return all;
}

void join_best_first(std::vector<CoarsePair>& pairs, Assembly& assembly) {
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const auto& a, const auto& b) { return a.score > b.score; });
    for (CoarsePair& pair : pairs) pair.used = assembly.join(pair) || pair.used;
}

std::string why_unplaced(const CoarseResult& result, std::size_t scan) {
    std::size_t candidates = 0;
    for (const CoarsePair& pair : result.pairs)
        candidates += pair.source == scan || pair.target == scan;
    if (candidates == 0) return "its shape fits no other scan";
    return "it fits " + std::to_string(candidates) +
           " pairs, but each contradicts the scans placed so far";
}

}  // namespace

std::string validate(const CoarseOptions& options) {
    const auto bad = [](const char* field, double value, const char* bound) {
        return std::string("CoarseOptions: ") + field + " = " + std::to_string(value) +
               ", expected " + bound;
    };
    if (!(options.detail_mm >= 0)) return bad("detail_mm", options.detail_mm, ">= 0");
    if (options.max_hypotheses < 1) return bad("max_hypotheses", options.max_hypotheses, ">= 1");
    if (!(options.min_overlap > 0 && options.min_overlap < 1))
        return bad("min_overlap", options.min_overlap, "in (0, 1)");
    if (!(options.max_contradiction > 0 && options.max_contradiction < 1))
        return bad("max_contradiction", options.max_contradiction, "in (0, 1)");
    if (!(options.max_looseness > 0 && options.max_looseness <= 1))
        return bad("max_looseness", options.max_looseness, "in (0, 1]");
    if (!(options.max_missing > 0 && options.max_missing <= 1))
        return bad("max_missing", options.max_missing, "in (0, 1]");
    return {};
}

CoarseResult place_scans(const std::vector<ScanSurface>& surfaces, const CoarseOptions& options) {
    if (const std::string wrong = validate(options); !wrong.empty())
        throw std::invalid_argument(wrong);
    CoarseResult result;
    result.scans.resize(surfaces.size());
    const double detail = result.detail_mm = detail_of(surfaces, options);
    if (!(detail > 0)) {
        for (CoarseScan& scan : result.scans) scan.reason = "it has no surface";
        return result;
    }
    std::vector<CheckedScan> scans;
    for (const ScanSurface& surface : surfaces)
        scans.push_back({thinned(surface, detail), LineOfSight(surface, 2 * surface.pitch_mm),
                         LineOfSight(surface, 2 * surface.pitch_mm, LineOfSight::From::laser)});
    const PairSearch search(scans, detail, options);
    Assembly assembly(scans, options, detail);
    const auto first_tries = static_cast<std::size_t>(options.max_hypotheses);
    result.pairs = search.poses(assembly.pairs_apart(), 0, first_tries);
    join_best_first(result.pairs, assembly);
    // Scans that the first tries left apart: their true pose may not have looked the likeliest.
    const auto more =
        search.poses(assembly.pairs_apart(), first_tries, kSecondChance * first_tries);
    result.pairs.insert(result.pairs.end(), more.begin(), more.end());
    join_best_first(result.pairs, assembly);
    const std::vector<std::size_t> placed = assembly.largest_group();
    for (const std::size_t i : placed) {
        if (placed.size() < 2 && surfaces.size() > 1) break;
        result.scans[i].placed = true;
        result.scans[i].world_from_scan =
            assembly.pose(placed.front()).inverse() * assembly.pose(i);
    }
    result.all_placed = !surfaces.empty();
    for (std::size_t i = 0; i < result.scans.size(); ++i) {
        if (result.scans[i].placed) continue;
        result.all_placed = false;
        result.scans[i].reason =
            surfaces[i].points.empty() ? "it has no surface" : why_unplaced(result, i);
    }
    return result;
}

}  // namespace stria
