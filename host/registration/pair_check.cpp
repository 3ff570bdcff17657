#include "host/registration/pair_check.h"

#include <algorithm>
#include <cmath>

namespace stria {
namespace {

using Eigen::Vector3d;

struct Count {
    double agree = 0, contradict = 0, missing = 0, square = 0;
};

/// True if the surface there faces the scan's camera and laser, lies in nothing's shadow, and the
/// scan saw nothing at all that way.
bool should_be_seen(const CheckedScan& scan, const Vector3d& point, const Vector3d& normal,
                    double tolerance_mm) {
    constexpr double kMinCosine = 0.6;  // 53 deg: flatter surface may well give no return
    return scan.sight.sees_nothing_at(point) &&
           normal.dot(scan.sight.towards_eye(point)) > kMinCosine &&
           normal.dot(scan.light.towards_eye(point)) > kMinCosine &&
           !scan.light.may_be_hidden(point, tolerance_mm);
}

Count count_one_way(const CheckedScan& source, const CheckedScan& target,
                    const Rigid3& target_from_source, const PairTolerance& tolerance) {
    constexpr double kMinCosine = 0.866;
    const double reach = std::max(1.5 * target.thin.pitch_mm, tolerance.surface_mm);
    Count count;
    for (std::size_t i = 0; i < source.thin.points.size(); i += tolerance.stride) {
        const Vector3d point = target_from_source * source.thin.points[i];
        bool agrees = false;
        if (target.thin.occupancy.may_be_near(point, reach))
            if (const auto hit = target.thin.tree.nearest(point, reach)) {
                const Vector3d& normal = target.thin.normals[hit->index];
                const double off = normal.dot(point - target.thin.points[hit->index]);
                const Vector3d own = target_from_source.rotation * source.thin.normals[i];
                agrees = std::abs(off) < tolerance.surface_mm && own.dot(normal) > kMinCosine;
                if (agrees) count.square += off * off;
            }
        if (agrees)
            ++count.agree;
        else if (!source.thin.is_border[i]) {
            const Vector3d normal = target_from_source.rotation * source.thin.normals[i];
            if (target.sight.at(point, tolerance.free_mm) == LineOfSight::Verdict::in_front)
                ++count.contradict;
            else if (should_be_seen(target, point, normal, tolerance.free_mm))
                ++count.missing;
        }
    }
    return count;
}

}  // namespace

PairCheck check_pair(const CheckedScan& source, const CheckedScan& target,
                     const Rigid3& target_from_source, const PairTolerance& tolerance) {
    PairCheck check;
    const double smaller =
        static_cast<double>(std::min(source.thin.points.size(), target.thin.points.size())) /
        static_cast<double>(tolerance.stride);
    if (!(smaller > 0)) return check;
    const Count there = count_one_way(source, target, target_from_source, tolerance);
    const Count back = count_one_way(target, source, target_from_source.inverse(), tolerance);
    const double agree = there.agree + back.agree;
    check.agreeing = 0.5 * agree;
    check.overlap = check.agreeing / smaller;
    check.contradiction = (there.contradict + back.contradict) / smaller;
    check.missing = (there.missing + back.missing) / smaller;
    check.rms_mm = agree > 0 ? std::sqrt((there.square + back.square) / agree) : 0;
    check.looseness = check.rms_mm * std::sqrt(3.0) / tolerance.surface_mm;
    return check;
}

}  // namespace stria
