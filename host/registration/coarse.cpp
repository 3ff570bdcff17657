#include "host/registration/coarse.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

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
    const auto middle = extents.begin() + static_cast<std::ptrdiff_t>(extents.size() / 2);
    std::nth_element(extents.begin(), middle, extents.end());
    return std::max(2 * pitch, *middle / 130);
}

/// Of the many poses that some shapes suggest, those under which the scans look most like one part:
/// a quick look at some hundred points, with room for the poses being rough.
std::vector<Rigid3> most_plausible(const CheckedScan& from, const CheckedScan& to,
                                   const std::vector<PoseHypothesis>& hypotheses, double detail,
                                   int count) {
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
    for (const auto& [rank, k] : order)
        if (poses.size() < static_cast<std::size_t>(count))
            poses.push_back(hypotheses[k].target_from_source);
    return poses;
}

/// Verified poses of one pair of scans, best first.
std::vector<CoarsePair> poses_of_pair(const std::vector<CheckedScan>& scans,
                                      const std::vector<ShapeKeys>& keys, std::size_t source,
                                      std::size_t target, double detail,
                                      const CoarseOptions& options) {
    const CheckedScan &from = scans[source], &to = scans[target];
    std::vector<CoarsePair> verified;
    const std::vector<PoseHypothesis> hypotheses =
        pose_hypotheses(keys[source], keys[target], detail, kHypotheses);
    for (const Rigid3& start :
         most_plausible(from, to, hypotheses, detail, options.max_hypotheses)) {
        const PairResult refined = register_pair(from.thin, to.thin, start, thin_options(detail));
        if (refined.matches == 0) continue;
        const PairCheck check =
            check_pair(from, to, refined.target_from_source, {0.5 * detail, 1.5 * detail, 1});
        if (check.overlap < options.min_overlap ||
            check.contradiction > options.max_contradiction || check.missing > options.max_missing)
            continue;
        const Vector3d centre = refined.target_from_source * from.thin.centre;
        const bool known =
            std::any_of(verified.begin(), verified.end(), [&](const CoarsePair& other) {
                const Rigid3 step = other.target_from_source * refined.target_from_source.inverse();
                return vector_from_rotation(step.rotation).norm() < 0.02 &&
                       (step * centre - centre).norm() < detail;
            });
        if (known) continue;
        CoarsePair pair;
        pair.source = source;
        pair.target = target;
        pair.target_from_source = refined.target_from_source;
        pair.overlap = check.overlap;
        pair.contradiction = check.contradiction;
        pair.rms_mm = check.rms_mm;
        pair.missing = check.missing;
        pair.score = check.agreeing * (1 - check.contradiction / options.max_contradiction) *
                     (1 - check.missing / options.max_missing);
        verified.push_back(pair);
    }
    return verified;
}

std::vector<CoarsePair> all_pairs(const std::vector<CheckedScan>& scans, double detail,
                                  const CoarseOptions& options) {
    std::vector<Eigen::MatrixXf> features(scans.size());
    for (std::size_t i = 0; i < scans.size(); ++i)
        features[i] = shape_features(scans[i].thin, 5 * detail, 10 * detail);
    std::vector<const ScanSurface*> surfaces;
    for (const CheckedScan& scan : scans) surfaces.push_back(&scan.thin);
    const auto points = distinctive_points(surfaces, features, kKeys);
    std::vector<ShapeKeys> keys;
    for (std::size_t i = 0; i < scans.size(); ++i)
        keys.push_back({scans[i].thin, features[i], points[i]});
    std::vector<std::pair<std::size_t, std::size_t>> tasks;
    for (std::size_t i = 0; i < scans.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) tasks.emplace_back(i, j);
    std::vector<std::vector<CoarsePair>> found(tasks.size());
    parallel_for_blocks(tasks.size(), 1, [&](std::size_t begin, std::size_t) {
        found[begin] =
            poses_of_pair(scans, keys, tasks[begin].first, tasks[begin].second, detail, options);
    });
    std::vector<CoarsePair> pairs;
    for (const auto& list : found) pairs.insert(pairs.end(), list.begin(), list.end());
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const auto& a, const auto& b) { return a.score > b.score; });
    return pairs;
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
    result.pairs = all_pairs(scans, detail, options);

    Assembly assembly(scans, options, detail);
    for (CoarsePair& pair : result.pairs) pair.used = assembly.join(pair);
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
