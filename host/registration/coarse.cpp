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
    bool is_contradicted(const std::vector<std::size_t>& staying,
                         const std::vector<std::size_t>& moving, const Rigid3& motion) const;
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
                               const std::vector<std::size_t>& moving, const Rigid3& motion) const {
    for (const std::size_t a : moving)
        for (const std::size_t b : staying) {
            const Rigid3 b_from_a = pose_[b].inverse() * motion * pose_[a];
            // Wider than for a pair: errors add up along the chain that joins them.
            const PairCheck check =
                check_pair(scans_[a], scans_[b], b_from_a, detail_, 2.5 * detail_);
            if (check.contradiction > options_.max_contradiction) return true;
        }
    return false;
}

bool Assembly::join(const CoarsePair& pair) {
    if (group_[pair.source] == group_[pair.target]) return false;
    const auto staying = members(group_[pair.target]), moving = members(group_[pair.source]);
    const Rigid3 motion =
        pose_[pair.target] * pair.target_from_source * pose_[pair.source].inverse();
    if (is_contradicted(staying, moving, motion)) return false;
    const std::size_t number = std::min(group_[pair.source], group_[pair.target]);
    std::vector<std::size_t> all = staying;
    for (const std::size_t i : moving) {
        pose_[i] = motion * pose_[i];
        all.push_back(i);
    }
    for (const std::size_t i : all) group_[i] = number;
    if (all.size() > 2) refine(all);
    return true;
}

/// All pairs of the group pull it straight before errors grow.
void Assembly::refine(const std::vector<std::size_t>& all) {
    SurfaceList surfaces;
    std::vector<ScanPose> poses;
    for (const std::size_t i : all) {
        surfaces.push_back(&scans_[i].thin);
        poses.emplace_back();
        poses.back().world_from_scan = pose_[i];
    }
    const JointResult result = register_jointly(surfaces, poses,
                                                {.start_distance_mm = 3 * detail_,
                                                 .samples_per_scan = 1000,
                                                 .max_iterations = 20,
                                                 .tolerance_mm = 0.02 * detail_});
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
    return std::max(2 * pitch, *middle / 90);
}

/// Verified poses of one pair of scans, best first.
std::vector<CoarsePair> poses_of_pair(const std::vector<CheckedScan>& scans,
                                      const std::vector<Eigen::MatrixXf>& features,
                                      std::size_t source, std::size_t target, double detail,
                                      const CoarseOptions& options) {
    const CheckedScan &from = scans[source], &to = scans[target];
    std::vector<CoarsePair> verified;
    for (const PoseHypothesis& hypothesis :
         pose_hypotheses(from.thin, features[source], to.thin, features[target], detail,
                         options.max_hypotheses)) {
        const PairResult refined = register_pair(from.thin, to.thin, hypothesis.target_from_source,
                                                 {.start_distance_mm = 3 * detail,
                                                  .samples_per_scan = 1000,
                                                  .max_iterations = 25,
                                                  .tolerance_mm = 0.02 * detail});
        if (refined.matches == 0) continue;
        const PairCheck check =
            check_pair(from, to, refined.target_from_source, detail, 1.5 * detail);
        if (check.overlap < options.min_overlap || check.contradiction > options.max_contradiction)
            continue;
        CoarsePair pair;
        pair.source = source;
        pair.target = target;
        pair.target_from_source = refined.target_from_source;
        pair.overlap = check.overlap;
        pair.contradiction = check.contradiction;
        pair.rms_mm = check.rms_mm;
        pair.score = check.agreeing * (1 - check.contradiction / options.max_contradiction);
        verified.push_back(pair);
    }
    return verified;
}

std::vector<CoarsePair> all_pairs(const std::vector<CheckedScan>& scans, double detail,
                                  const CoarseOptions& options) {
    std::vector<Eigen::MatrixXf> features(scans.size());
    for (std::size_t i = 0; i < scans.size(); ++i)
        features[i] = shape_features(scans[i].thin, 5 * detail, 10 * detail);
    std::vector<std::pair<std::size_t, std::size_t>> tasks;
    for (std::size_t i = 0; i < scans.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) tasks.emplace_back(i, j);
    std::vector<std::vector<CoarsePair>> found(tasks.size());
    parallel_for_blocks(tasks.size(), 1, [&](std::size_t begin, std::size_t) {
        found[begin] = poses_of_pair(scans, features, tasks[begin].first, tasks[begin].second,
                                     detail, options);
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
    return {};
}

CoarseResult place_scans(const std::vector<ScanSurface>& surfaces, const CoarseOptions& options) {
    if (const std::string wrong = validate(options); !wrong.empty())
        throw std::invalid_argument(wrong);
    CoarseResult result;
    result.scans.resize(surfaces.size());
    const double detail = detail_of(surfaces, options);
    if (!(detail > 0)) {
        for (CoarseScan& scan : result.scans) scan.reason = "it has no surface";
        return result;
    }
    std::vector<CheckedScan> scans;
    for (const ScanSurface& surface : surfaces)
        scans.push_back({thinned(surface, detail), LineOfSight(surface, detail)});
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
