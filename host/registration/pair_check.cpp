#include "host/registration/pair_check.h"

#include <algorithm>
#include <cmath>

namespace stria {
namespace {

using Eigen::Vector3d;

struct Count {
    double agree = 0, contradict = 0, square = 0;
};

Count count_one_way(const CheckedScan& source, const CheckedScan& target,
                    const Rigid3& target_from_source, double detail_mm, double free_mm) {
    constexpr double kMinCosine = 0.866;
    Count count;
    for (std::size_t i = 0; i < source.thin.points.size(); ++i) {
        const Vector3d point = target_from_source * source.thin.points[i];
        bool agrees = false;
        if (target.thin.occupancy.may_be_near(point, 1.5 * detail_mm))
            if (const auto hit = target.thin.tree.nearest(point, 1.5 * detail_mm)) {
                const Vector3d& normal = target.thin.normals[hit->index];
                const double off = normal.dot(point - target.thin.points[hit->index]);
                const Vector3d own = target_from_source.rotation * source.thin.normals[i];
                agrees = std::abs(off) < 0.5 * detail_mm && own.dot(normal) > kMinCosine;
                if (agrees) count.square += off * off;
            }
        if (agrees)
            ++count.agree;
        else if (!source.thin.is_border[i] &&
                 target.sight.at(point, free_mm) == LineOfSight::Verdict::in_front)
            ++count.contradict;
    }
    return count;
}

}  // namespace

PairCheck check_pair(const CheckedScan& source, const CheckedScan& target,
                     const Rigid3& target_from_source, double detail_mm, double free_mm) {
    PairCheck check;
    const auto smaller =
        static_cast<double>(std::min(source.thin.points.size(), target.thin.points.size()));
    if (smaller == 0) return check;
    const Count there = count_one_way(source, target, target_from_source, detail_mm, free_mm);
    const Count back =
        count_one_way(target, source, target_from_source.inverse(), detail_mm, free_mm);
    const double agree = there.agree + back.agree;
    check.agreeing = 0.5 * agree;
    check.overlap = check.agreeing / smaller;
    check.contradiction = (there.contradict + back.contradict) / smaller;
    check.rms_mm = agree > 0 ? std::sqrt((there.square + back.square) / agree) : 0;
    return check;
}

}  // namespace stria
