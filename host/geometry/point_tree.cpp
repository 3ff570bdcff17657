#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>

#include "host/geometry/nearest.h"

namespace stria {
namespace {

constexpr std::uint32_t kLeafSize = 8;

struct Node {
    // Inner: children begin, begin + 1 (nodes are stored in pairs). Leaf: points [begin, end).
    std::uint32_t begin = 0, end = 0;
    int axis = -1;  ///< -1: leaf
    double split = 0;
};

}  // namespace

struct PointTree::Tree {
    std::vector<Node> nodes;
    std::vector<Eigen::Vector3d> points;  ///< in the order of the leaves
    std::vector<std::uint32_t> original;  ///< index of each in the input

    explicit Tree(const std::vector<Eigen::Vector3d>& input);
    void build(std::uint32_t node, std::uint32_t begin, std::uint32_t end,
               const std::vector<Eigen::Vector3d>& input);

    /// Calls leaf(point slot, squared distance) for points within limit2(), near side first.
    /// Points exactly on the limit are offered, so that ties can be broken by index.
    template <typename Limit, typename Visit>
    void search(std::uint32_t node, const Eigen::Vector3d& query, Eigen::Vector3d& offset,
                double offset2, const Limit& limit2, const Visit& visit) const {
        const Node& here = nodes[node];
        if (here.axis < 0) {
            for (std::uint32_t slot = here.begin; slot < here.end; ++slot) {
                const double distance2 = (points[slot] - query).squaredNorm();
                if (distance2 <= limit2()) visit(slot, distance2);
            }
            return;
        }
        // Arya and Mount 1993: the distance to a box is updated one axis at a time.
        const double across = query[here.axis] - here.split;
        const std::uint32_t near = here.begin + (across < 0 ? 0 : 1);
        const std::uint32_t far = here.begin + (across < 0 ? 1 : 0);
        search(near, query, offset, offset2, limit2, visit);
        const double before = offset[here.axis];
        const double far2 = offset2 - before * before + across * across;
        // The running difference rounds, so the bound is taken a little low.
        if (far2 * (1.0 - 1e-12) <= limit2()) {
            offset[here.axis] = across;
            search(far, query, offset, far2, limit2, visit);
            offset[here.axis] = before;
        }
    }

    template <typename Limit, typename Visit>
    void search(const Eigen::Vector3d& query, const Limit& limit2, const Visit& visit) const {
        if (points.empty() || !query.allFinite()) return;
        Eigen::Vector3d offset = Eigen::Vector3d::Zero();
        search(0, query, offset, 0.0, limit2, visit);
    }
};

PointTree::Tree::Tree(const std::vector<Eigen::Vector3d>& input) {
    for (std::size_t i = 0; i < input.size(); ++i)
        if (input[i].allFinite()) original.push_back(static_cast<std::uint32_t>(i));
    nodes.reserve(2 * original.size() / kLeafSize + 2);
    nodes.emplace_back();
    build(0, 0, static_cast<std::uint32_t>(original.size()), input);
    points.reserve(original.size());
    for (std::uint32_t index : original) points.push_back(input[index]);
}

void PointTree::Tree::build(std::uint32_t node, std::uint32_t begin, std::uint32_t end,
                            const std::vector<Eigen::Vector3d>& input) {
    nodes[node] = {.begin = begin, .end = end, .axis = -1, .split = 0};
    if (end - begin <= kLeafSize) return;
    Eigen::Vector3d low = input[original[begin]], high = low;
    for (std::uint32_t i = begin; i < end; ++i) {
        low = low.cwiseMin(input[original[i]]);
        high = high.cwiseMax(input[original[i]]);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const std::uint32_t middle = begin + (end - begin) / 2;
    const auto first = original.begin();
    std::nth_element(first + begin, first + middle, first + end,
                     [&](std::uint32_t a, std::uint32_t b) {
                         const double left = input[a][axis], right = input[b][axis];
                         return left < right || (left == right && a < b);
                     });
    const double split = input[original[middle]][axis];
    const auto child = static_cast<std::uint32_t>(nodes.size());
    nodes.emplace_back();
    nodes.emplace_back();
    nodes[node] = {.begin = child, .end = 0, .axis = axis, .split = split};
    build(child, begin, middle, input);
    build(child + 1, middle, end, input);
}

PointTree::PointTree(const std::vector<Eigen::Vector3d>& points)
    : tree_(std::make_unique<Tree>(points)) {}
PointTree::~PointTree() = default;
PointTree::PointTree(PointTree&&) noexcept = default;
PointTree& PointTree::operator=(PointTree&&) noexcept = default;

std::optional<PointTree::Hit> PointTree::nearest(const Eigen::Vector3d& query,
                                                 double max_distance_mm) const {
    if (!(max_distance_mm >= 0)) return std::nullopt;
    double best2 = max_distance_mm * max_distance_mm;
    std::uint32_t best = std::numeric_limits<std::uint32_t>::max();
    bool found = false;
    tree_->search(
        query, [&] { return best2; },
        [&](std::uint32_t slot, double distance2) {
            const std::uint32_t index = tree_->original[slot];
            if (found && distance2 == best2 && index > best) return;
            found = true;
            best2 = distance2;
            best = index;
        });
    if (!found) return std::nullopt;
    return Hit{best, std::sqrt(best2)};
}

std::vector<PointTree::Hit> PointTree::nearest_few(const Eigen::Vector3d& query, int count) const {
    std::vector<Hit> hits;
    if (count <= 0) return hits;
    using Entry = std::pair<double, std::uint32_t>;  // squared distance, index: the worst on top
    std::priority_queue<Entry> kept;
    const auto full = [&] { return kept.size() == static_cast<std::size_t>(count); };
    tree_->search(
        query, [&] { return full() ? kept.top().first : std::numeric_limits<double>::max(); },
        [&](std::uint32_t slot, double distance2) {
            kept.emplace(distance2, tree_->original[slot]);
            if (kept.size() > static_cast<std::size_t>(count)) kept.pop();
        });
    for (; !kept.empty(); kept.pop())
        hits.push_back({kept.top().second, std::sqrt(kept.top().first)});
    std::reverse(hits.begin(), hits.end());
    return hits;
}

std::vector<std::uint32_t> PointTree::within(const Eigen::Vector3d& query, double radius_mm) const {
    std::vector<std::uint32_t> indices;
    if (!(radius_mm >= 0)) return indices;
    const double radius2 = radius_mm * radius_mm;
    tree_->search(
        query, [&] { return radius2; },
        [&](std::uint32_t slot, double) { indices.push_back(tree_->original[slot]); });
    std::sort(indices.begin(), indices.end());
    return indices;
}

}  // namespace stria
