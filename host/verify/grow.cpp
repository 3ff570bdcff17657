#include "host/verify/grow.h"

#include <algorithm>

#include "firmware/core/median.h"

namespace stria {

std::uint32_t Groups::largest() const {
    return static_cast<std::uint32_t>(std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
}

Groups grow(const std::vector<Eigen::Vector3d>& places, double reach_mm) {
    constexpr auto kNone = static_cast<std::uint32_t>(-1);
    Groups groups{std::vector<std::uint32_t>(places.size(), kNone), {}};
    const PointTree tree(places);
    std::vector<std::uint32_t> front;
    for (std::uint32_t seed = 0; seed < places.size(); ++seed) {
        if (groups.of[seed] != kNone) continue;
        const auto number = static_cast<std::uint32_t>(groups.sizes.size());
        groups.sizes.push_back(1);
        groups.of[seed] = number;
        front.assign(1, seed);
        while (!front.empty()) {
            const std::uint32_t at = front.back();
            front.pop_back();
            for (const std::uint32_t next : tree.within(places[at], reach_mm)) {
                if (groups.of[next] != kNone) continue;
                groups.of[next] = number;
                ++groups.sizes[number];
                front.push_back(next);
            }
        }
    }
    return groups;
}

std::vector<std::uint8_t> groups_apart(const Groups& groups, const std::vector<double>& off_mm,
                                       std::size_t many, double far_mm) {
    std::vector<std::vector<double>> by_group(groups.sizes.size());
    for (std::size_t i = 0; i < off_mm.size(); ++i) by_group[groups.of[i]].push_back(off_mm[i]);
    std::vector<std::uint8_t> apart;
    for (std::vector<double>& distances : by_group)
        apart.push_back(distances.size() >= many && median(std::move(distances)) > far_mm);
    return apart;
}

double median_pitch(const std::vector<Eigen::Vector3d>& places, const PointTree& tree) {
    std::vector<double> distances;
    const std::size_t stride = std::max<std::size_t>(1, places.size() / 500);
    for (std::size_t i = 0; i < places.size(); i += stride) {
        const auto two = tree.nearest_few(places[i], 2);
        if (two.size() == 2) distances.push_back(two[1].distance_mm);
    }
    return median(std::move(distances));
}

std::vector<Eigen::Vector3d> places_of(const std::vector<Eigen::Vector3d>& places,
                                       const std::vector<std::uint32_t>& indices) {
    std::vector<Eigen::Vector3d> some;
    some.reserve(indices.size());
    for (const std::uint32_t i : indices) some.push_back(places[i]);
    return some;
}

std::vector<std::uint32_t> thinned(const std::vector<std::uint32_t>& indices, std::size_t most) {
    if (indices.size() <= most) return indices;
    std::vector<std::uint32_t> few;
    for (std::size_t i = 0; i < most; ++i) few.push_back(indices[i * indices.size() / most]);
    return few;
}

}  // namespace stria
