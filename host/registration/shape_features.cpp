#include "host/registration/shape_features.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <tuple>

#include "host/geometry/parallel.h"

namespace stria {
namespace {

using Eigen::MatrixXf;
using Eigen::Vector3d;

constexpr int kBins = 11;
constexpr int kSize = 3 * kBins;
constexpr double kPi = std::numbers::pi;
using Histogram = Eigen::Matrix<float, kSize, 1>;

int bin_of(double value, double low, double high) {
    return std::clamp(static_cast<int>((value - low) / (high - low) * kBins), 0, kBins - 1);
}

/// The three angles between two oriented points (Rusu 2009, eq. 1), counted into `histogram`.
void count_pair(const Vector3d& p, const Vector3d& n, const Vector3d& q, const Vector3d& m,
                Histogram& histogram) {
    const Vector3d step = q - p;
    const double distance = step.norm();
    if (!(distance > 0)) return;
    const Vector3d towards = step / distance;
    const Vector3d v = n.cross(towards);  // the frame is n, v, w
    const double sine = v.norm();
    if (sine < 1e-6) return;
    const Vector3d unit_v = v / sine;
    const Vector3d w = n.cross(unit_v);
    histogram[bin_of(unit_v.dot(m), -1, 1)] += 1;
    histogram[kBins + bin_of(n.dot(towards), -1, 1)] += 1;
    histogram[2 * kBins + bin_of(std::atan2(w.dot(m), n.dot(m)), -kPi, kPi)] += 1;
}

void normalise(Histogram& histogram) {
    for (int part = 0; part < 3; ++part) {
        const float sum = histogram.segment<kBins>(part * kBins).sum();
        if (sum > 0) histogram.segment<kBins>(part * kBins) /= sum;
    }
}

MatrixXf features_at(const ScanSurface& surface, double radius_mm) {
    const std::size_t count = surface.points.size();
    std::vector<std::vector<std::uint32_t>> near(count);
    std::vector<Histogram> simple(count, Histogram::Zero());
    constexpr std::size_t kGrain = 256;
    parallel_for_blocks(count, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            near[i] = surface.tree.within(surface.points[i], radius_mm);
            for (const std::uint32_t k : near[i])
                if (k != i)
                    count_pair(surface.points[i], surface.normals[i], surface.points[k],
                               surface.normals[k], simple[i]);
            normalise(simple[i]);
        }
    });
    MatrixXf features(kSize, static_cast<Eigen::Index>(count));
    parallel_for_blocks(count, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            Histogram sum = simple[i];
            for (const std::uint32_t k : near[i]) {
                if (k == i) continue;
                const double distance = (surface.points[k] - surface.points[i]).norm();
                const double weight = radius_mm / std::max(distance, 0.1 * radius_mm) /
                                      static_cast<double>(near[i].size());
                sum += static_cast<float>(weight) * simple[k];
            }
            normalise(sum);
            features.col(static_cast<Eigen::Index>(i)) = sum;
        }
    });
    return features;
}

}  // namespace

ScanSurface thinned(const ScanSurface& surface, double detail_mm) {
    using Cube = std::tuple<std::int64_t, std::int64_t, std::int64_t>;
    std::vector<std::pair<Cube, std::uint32_t>> order;
    order.reserve(surface.points.size());
    for (std::uint32_t i = 0; i < surface.points.size(); ++i) {
        const Vector3d at = ((surface.points[i] - surface.low) / detail_mm).array().floor();
        order.push_back({Cube(at.x(), at.y(), at.z()), i});
    }
    std::sort(order.begin(), order.end());

    ScanSurface thin;
    thin.pitch_mm = detail_mm;
    thin.stations = surface.stations;
    thin.is_whole = surface.is_whole;
    thin.low = surface.low;
    thin.high = surface.high;
    for (std::size_t begin = 0; begin < order.size();) {
        Vector3d point = Vector3d::Zero(), normal = Vector3d::Zero(), towards = Vector3d::Zero();
        bool border = false;
        std::size_t end = begin;
        for (; end < order.size() && order[end].first == order[begin].first; ++end) {
            const std::uint32_t i = order[end].second;
            point += surface.points[i];
            normal += surface.normals[i];
            towards += surface.to_camera[i];
            border = border || surface.is_border[i];
        }
        thin.points.push_back(point / static_cast<double>(end - begin));
        thin.normals.push_back(normal.normalized());
        thin.to_camera.push_back(towards.normalized());
        thin.is_border.push_back(border);
        thin.centre += thin.points.back();
        begin = end;
    }
    if (thin.points.empty()) return thin;
    thin.centre /= static_cast<double>(thin.points.size());
    for (std::uint32_t i = 0; i < thin.points.size(); ++i)
        if (!thin.is_border[i]) thin.samples.push_back(i);
    thin.tree = PointTree(thin.points);
    thin.occupancy = OccupancyGrid(thin.points, 2 * detail_mm);
    return thin;
}

MatrixXf shape_features(const ScanSurface& surface, double small_radius_mm,
                        double large_radius_mm) {
    MatrixXf features(2 * kSize, static_cast<Eigen::Index>(surface.points.size()));
    if (surface.points.empty()) return features;
    features.topRows(kSize) = features_at(surface, small_radius_mm);
    features.bottomRows(kSize) = features_at(surface, large_radius_mm);
    return features;
}

std::vector<std::vector<std::uint32_t>> distinctive_points(
    const std::vector<const ScanSurface*>& surfaces, const std::vector<MatrixXf>& features,
    std::size_t count) {
    // A sample of what is common: the same number of points of every surface.
    constexpr Eigen::Index kSample = 1200;
    constexpr std::ptrdiff_t kRank = 24;  // 2 %: what is rarer than that is distinctive
    const auto scans = static_cast<Eigen::Index>(surfaces.size());
    const Eigen::Index share =
        std::max<Eigen::Index>(1, kSample / std::max<Eigen::Index>(1, scans));
    MatrixXf sample(2 * kSize, share * scans);
    Eigen::Index filled = 0;
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        const auto& from = surfaces[s]->samples;
        for (Eigen::Index k = 0; k < share && !from.empty(); ++k) {
            const auto at =
                static_cast<std::size_t>(k) * from.size() / static_cast<std::size_t>(share);
            sample.col(filled++) = features[s].col(from[at]);
        }
    }
    std::vector<std::vector<std::uint32_t>> chosen(surfaces.size());
    if (filled <= kRank) return chosen;
    const MatrixXf common = sample.leftCols(filled);
    const Eigen::VectorXf squares = common.colwise().squaredNorm().transpose();
    parallel_for_blocks(surfaces.size(), 1, [&](std::size_t s, std::size_t) {
        const auto& from = surfaces[s]->samples;
        std::vector<std::pair<float, std::uint32_t>> rarity;
        for (const std::uint32_t point : from) {
            Eigen::VectorXf distance =
                squares - 2.0F * (common.transpose() * features[s].col(point));
            std::nth_element(distance.data(), distance.data() + kRank,
                             distance.data() + distance.size());
            rarity.emplace_back(-(distance[kRank] + features[s].col(point).squaredNorm()), point);
        }
        std::sort(rarity.begin(), rarity.end());
        std::vector<std::uint32_t>& points = chosen[s];
        for (std::size_t k = 0; k < std::min(rarity.size(), 2 * count / 3); ++k)
            points.push_back(rarity[k].second);
        const std::size_t even = std::min(from.size(), count - 2 * count / 3);
        for (std::size_t k = 0; k < even; ++k) points.push_back(from[k * from.size() / even]);
        std::sort(points.begin(), points.end());
        points.erase(std::unique(points.begin(), points.end()), points.end());
    });
    return chosen;
}

}  // namespace stria
