#include "host/fusion/closing_body.h"

#include <algorithm>

namespace stria {

ClosingBody::ClosingBody() {
    low.fill(1e300);
    high.fill(-1e300);
}

const Eigen::Vector3d& ClosingBody::axis(int k) {
    static const std::array<Eigen::Vector3d, kAxes> kDirections = [] {
        std::array<Eigen::Vector3d, kAxes> d = {{{1, 0, 0},
                                                 {0, 1, 0},
                                                 {0, 0, 1},
                                                 {1, 1, 0},
                                                 {1, -1, 0},
                                                 {1, 0, 1},
                                                 {1, 0, -1},
                                                 {0, 1, 1},
                                                 {0, 1, -1},
                                                 {1, 1, 1},
                                                 {1, 1, -1},
                                                 {1, -1, 1},
                                                 {1, -1, -1}}};
        for (Eigen::Vector3d& direction : d) direction.normalize();
        return d;
    }();
    return kDirections[static_cast<std::size_t>(k)];
}

void ClosingBody::include(const Eigen::Vector3d& point) {
    for (int k = 0; k < kAxes; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const double at = axis(k).dot(point);
        low[i] = std::min(low[i], at);
        high[i] = std::max(high[i], at);
    }
}

void ClosingBody::grow(double mm) {
    for (double& value : low) value -= mm;
    for (double& value : high) value += mm;
}

int ClosingBody::holds(const Eigen::Vector3d& centre, double radius_mm) const {
    int answer = 2;
    for (int k = 0; k < kAxes; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const double at = axis(k).dot(centre);
        if (at < low[i] - radius_mm || at > high[i] + radius_mm) return 0;
        if (at < low[i] + radius_mm || at > high[i] - radius_mm) answer = 1;
    }
    return answer;
}

}  // namespace stria
