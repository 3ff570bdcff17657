#include "host/geometry/align.h"

#include <Eigen/SVD>
#include <stdexcept>
#include <string>

namespace stria {

Rigid3 align_points(std::span<const Eigen::Vector3d> from, std::span<const Eigen::Vector3d> to,
                    std::span<const double> weights) {
    if (from.size() != to.size() || (!weights.empty() && weights.size() != from.size()))
        throw std::invalid_argument("align_points: " + std::to_string(from.size()) + " from, " +
                                    std::to_string(to.size()) + " to, " +
                                    std::to_string(weights.size()) + " weights: sizes differ");
    const auto weight = [&](std::size_t i) { return weights.empty() ? 1.0 : weights[i]; };

    double total = 0;
    Eigen::Vector3d mean_from = Eigen::Vector3d::Zero(), mean_to = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < from.size(); ++i) {
        total += weight(i);
        mean_from += weight(i) * from[i];
        mean_to += weight(i) * to[i];
    }
    if (!(total > 0)) return {};
    mean_from /= total;
    mean_to /= total;

    Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < from.size(); ++i)
        cross += weight(i) * (to[i] - mean_to) * (from[i] - mean_from).transpose();
    // nearest_rotation is Umeyama's U S V' with S = diag(1, 1, det(U V')).
    const Eigen::Matrix3d rotation = nearest_rotation(cross);
    return {rotation, mean_to - rotation * mean_from};
}

}  // namespace stria
