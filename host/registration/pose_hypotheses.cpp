#include "host/registration/pose_hypotheses.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "host/geometry/align.h"

namespace stria {
namespace {

using Eigen::MatrixXf;
using Eigen::Vector3d;

constexpr std::size_t kMaxKeys = 1500;        ///< points of each scan that are compared
constexpr std::size_t kMaxCandidates = 2000;  ///< correspondences
constexpr int kNearest = 3;
constexpr std::size_t kSeeds = 200;
constexpr std::size_t kMembers = 40;  ///< of a consistent set
constexpr double kMaxAngle = 0.35;    ///< rad, between angles of normals (20 deg)

struct Candidate {
    std::uint32_t source, target;
    float distance;
};

MatrixXf columns(const MatrixXf& features, const std::vector<std::uint32_t>& keys) {
    MatrixXf chosen(features.rows(), static_cast<Eigen::Index>(keys.size()));
    for (std::size_t i = 0; i < keys.size(); ++i)
        chosen.col(static_cast<Eigen::Index>(i)) = features.col(keys[i]);
    return chosen;
}

/// For each column of `distance2` the rows of its few smallest entries.
std::vector<std::array<std::int32_t, kNearest>> smallest_rows(const MatrixXf& distance2) {
    std::vector<std::array<std::int32_t, kNearest>> result(
        static_cast<std::size_t>(distance2.cols()));
    for (Eigen::Index column = 0; column < distance2.cols(); ++column) {
        std::array<float, kNearest> best;
        best.fill(1e30F);
        auto& rows = result[static_cast<std::size_t>(column)];
        rows.fill(-1);
        for (Eigen::Index row = 0; row < distance2.rows(); ++row) {
            const float d = distance2(row, column);
            if (d >= best[kNearest - 1]) continue;
            int at = kNearest - 1;
            for (; at > 0 && best[static_cast<std::size_t>(at - 1)] > d; --at) {
                best[static_cast<std::size_t>(at)] = best[static_cast<std::size_t>(at - 1)];
                rows[static_cast<std::size_t>(at)] = rows[static_cast<std::size_t>(at - 1)];
            }
            best[static_cast<std::size_t>(at)] = d;
            rows[static_cast<std::size_t>(at)] = static_cast<std::int32_t>(row);
        }
    }
    return result;
}

/// Pairs of points each among the other's few most alike.
std::vector<Candidate> mutual_candidates(const ShapeKeys& source, const ShapeKeys& target) {
    const MatrixXf a = columns(source.features, source.points);
    const MatrixXf b = columns(target.features, target.points);
    MatrixXf distance2 = -2.0F * a.transpose() * b;
    distance2.colwise() += a.colwise().squaredNorm().transpose();
    distance2.rowwise() += b.colwise().squaredNorm();
    const auto of_target = smallest_rows(distance2);
    const auto of_source = smallest_rows(distance2.transpose());
    std::vector<Candidate> candidates;
    for (std::size_t i = 0; i < of_source.size(); ++i)
        for (const std::int32_t j : of_source[i]) {
            if (j < 0) continue;
            const auto& back = of_target[static_cast<std::size_t>(j)];
            if (std::find(back.begin(), back.end(), static_cast<std::int32_t>(i)) == back.end())
                continue;
            candidates.push_back({source.points[i], target.points[static_cast<std::size_t>(j)],
                                  distance2(static_cast<Eigen::Index>(i), j)});
        }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const auto& x, const auto& y) { return x.distance < y.distance; });
    if (candidates.size() > kMaxCandidates) candidates.resize(kMaxCandidates);
    return candidates;
}

/// A square matrix of bits.
class BitMatrix {
  public:
    explicit BitMatrix(std::size_t size)
        : words_((size + 63) / 64), bits_(size * words_, 0), size_(size) {}
    void set(std::size_t i, std::size_t j) {
        bits_[i * words_ + j / 64] |= std::uint64_t{1} << (j % 64);
        bits_[j * words_ + i / 64] |= std::uint64_t{1} << (i % 64);
    }
    bool get(std::size_t i, std::size_t j) const {
        return (bits_[i * words_ + j / 64] >> (j % 64) & 1) != 0;
    }
    int shared(std::size_t i, std::size_t j) const {
        int count = 0;
        for (std::size_t w = 0; w < words_; ++w)
            count += std::popcount(bits_[i * words_ + w] & bits_[j * words_ + w]);
        return count;
    }
    std::size_t size() const { return size_; }

  private:
    std::size_t words_;
    std::vector<std::uint64_t> bits_;
    std::size_t size_;
};

double angle_of(double cosine) { return std::acos(std::clamp(cosine, -1.0, 1.0)); }

BitMatrix compatibility(const ScanSurface& source, const ScanSurface& target,
                        const std::vector<Candidate>& candidates, double detail_mm) {
    BitMatrix compatible(candidates.size());
    const double tolerance = 1.2 * detail_mm, least = 6 * detail_mm;
    for (std::size_t i = 0; i < candidates.size(); ++i)
        for (std::size_t j = i + 1; j < candidates.size(); ++j) {
            const Candidate &x = candidates[i], &y = candidates[j];
            const Vector3d p = source.points[y.source] - source.points[x.source];
            const Vector3d q = target.points[y.target] - target.points[x.target];
            const double pl = p.norm(), ql = q.norm();
            if (pl < least || ql < least || std::abs(pl - ql) > tolerance) continue;
            const Vector3d &n1 = source.normals[x.source], &n2 = source.normals[y.source];
            const Vector3d &m1 = target.normals[x.target], &m2 = target.normals[y.target];
            if (std::abs(angle_of(n1.dot(n2)) - angle_of(m1.dot(m2))) > kMaxAngle) continue;
            if (std::abs(angle_of(n1.dot(p) / pl) - angle_of(m1.dot(q) / ql)) > kMaxAngle) continue;
            if (std::abs(angle_of(n2.dot(p) / pl) - angle_of(m2.dot(q) / ql)) > kMaxAngle) continue;
            compatible.set(i, j);
        }
    return compatible;
}

class PoseFinder {
  public:
    PoseFinder(const ScanSurface& source, const ScanSurface& target,
               const std::vector<Candidate>& candidates, double detail_mm)
        : source_(source),
          target_(target),
          candidates_(candidates),
          detail_(detail_mm),
          compatible_(compatibility(source, target, candidates, detail_mm)) {}

    std::vector<PoseHypothesis> find(int max_count) const;

  private:
    std::vector<std::size_t> by_standing() const;
    std::vector<std::size_t> partners_of(std::size_t seed) const;
    Rigid3 fit(const std::vector<std::size_t>& members) const;
    std::vector<std::size_t> agreeing(const Rigid3& pose) const;

    const ScanSurface& source_;
    const ScanSurface& target_;
    const std::vector<Candidate>& candidates_;
    double detail_;
    BitMatrix compatible_;
};

/// All candidates, those first that have the most compatible partners, weighed by what the partners
/// share with them.
std::vector<std::size_t> PoseFinder::by_standing() const {
    const std::size_t count = candidates_.size();
    std::vector<double> score(count, 0.0);
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = i + 1; j < count; ++j)
            if (compatible_.get(i, j)) {
                const int shared = compatible_.shared(i, j);
                score[i] += shared;
                score[j] += shared;
            }
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return score[a] > score[b]; });
    return order;
}

Rigid3 PoseFinder::fit(const std::vector<std::size_t>& members) const {
    std::vector<Vector3d> from, to;
    for (const std::size_t i : members) {
        const Candidate& c = candidates_[i];
        from.push_back(source_.points[c.source]);
        to.push_back(target_.points[c.target]);
        // A point on the normal says how the surface lies, as far off as sets are wide.
        const double arm = 4 * detail_;
        from.push_back(from.back() + arm * source_.normals[c.source]);
        to.push_back(to.back() + arm * target_.normals[c.target]);
    }
    return align_points(from, to);
}

std::vector<std::size_t> PoseFinder::agreeing(const Rigid3& pose) const {
    std::vector<std::size_t> members;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
        const Candidate& c = candidates_[i];
        if ((pose * source_.points[c.source] - target_.points[c.target]).norm() < 2.5 * detail_ &&
            (pose.rotation * source_.normals[c.source]).dot(target_.normals[c.target]) > 0.85)
            members.push_back(i);
    }
    return members;
}

/// The seed and the partners that share most with it.
std::vector<std::size_t> PoseFinder::partners_of(std::size_t seed) const {
    std::vector<std::pair<int, std::size_t>> partners;
    for (std::size_t j = 0; j < candidates_.size(); ++j)
        if (compatible_.get(seed, j)) partners.emplace_back(-compatible_.shared(seed, j), j);
    std::sort(partners.begin(), partners.end());
    std::vector<std::size_t> members = {seed};
    for (const auto& [negative, j] : partners) {
        if (members.size() >= kMembers) break;
        members.push_back(j);
    }
    return members;
}

std::vector<PoseHypothesis> PoseFinder::find(int max_count) const {
    std::vector<PoseHypothesis> found;
    std::vector<std::uint8_t> spent(candidates_.size(), 0);  // has led to a pose already
    std::size_t tried = 0;
    for (const std::size_t seed : by_standing()) {
        if (spent[seed]) continue;
        if (++tried > kSeeds) break;
        std::vector<std::size_t> members = partners_of(seed);
        if (members.size() < 3) continue;
        Rigid3 pose = fit(members);
        for (int round = 0; round < 3; ++round) {
            members = agreeing(pose);
            if (members.size() < 3) break;
            pose = fit(members);
        }
        if (members.size() < 3) continue;
        for (const std::size_t i : members) spent[i] = 1;
        found.push_back({pose, static_cast<int>(members.size())});
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.support > b.support; });
    std::vector<PoseHypothesis> distinct;
    for (const PoseHypothesis& candidate : found) {
        if (distinct.size() >= static_cast<std::size_t>(max_count)) break;
        const bool known =
            std::any_of(distinct.begin(), distinct.end(), [&](const PoseHypothesis& other) {
                const Rigid3 step =
                    candidate.target_from_source * other.target_from_source.inverse();
                const Vector3d centre = other.target_from_source * source_.centre;
                return vector_from_rotation(step.rotation).norm() < 0.15 &&
                       (step * centre - centre).norm() < 4 * detail_;
            });
        if (!known) distinct.push_back(candidate);
    }
    return distinct;
}

}  // namespace

std::vector<PoseHypothesis> pose_hypotheses(const ShapeKeys& source, const ShapeKeys& target,
                                            double detail_mm, int max_count) {
    const std::vector<Candidate> candidates = mutual_candidates(source, target);
    if (candidates.size() < 3) return {};
    return PoseFinder(source.surface, target.surface, candidates, detail_mm).find(max_count);
}

}  // namespace stria
