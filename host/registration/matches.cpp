#include "host/registration/matches.h"

#include <algorithm>
#include <cmath>

#include "host/geometry/parallel.h"

namespace stria {
namespace {

using Eigen::Vector3d;
constexpr std::uint32_t kNone = 0xffffffffU;

}  // namespace

std::vector<Match> find_matches(const ScanSurface& source, const ScanSurface& target,
                                const Rigid3& target_from_source, const MatchGates& gates,
                                std::span<const std::uint32_t> samples,
                                std::vector<std::uint32_t>& warm) {
    warm.resize(samples.size(), kNone);
    constexpr std::size_t kGrain = 4096;
    std::vector<std::vector<Match>> found(samples.size() / kGrain + 1);
    parallel_for_blocks(samples.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        std::uint32_t last = kNone;
        for (std::size_t i = begin; i < end; ++i) {
            const Vector3d point = target_from_source * source.points[samples[i]];
            if (!target.occupancy.may_be_near(point, gates.max_distance_mm)) continue;
            double limit = gates.max_distance_mm;
            for (const std::uint32_t seen : {warm[i], last}) {  // any point bounds the nearest
                if (seen == kNone) continue;
                // A little above it, so that rounding cannot shut it out.
                limit = std::min(limit, (target.points[seen] - point).norm() * (1 + 1e-12));
            }
            const auto hit = target.tree.nearest(point, limit);
            if (!hit) continue;
            warm[i] = last = hit->index;
            if (target.is_border[hit->index]) continue;
            const Vector3d normal = target_from_source.rotation * source.normals[samples[i]];
            if (normal.dot(target.normals[hit->index]) < gates.min_normal_cosine) continue;
            found[begin / kGrain].push_back({samples[i], hit->index});
        }
    });
    std::vector<Match> all;
    for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
    return all;
}

std::vector<std::uint32_t> ordered_samples(const ScanSurface& surface, std::size_t count) {
    const std::size_t taken = std::min(count, surface.samples.size());
    std::vector<std::uint32_t> samples(
        surface.samples.begin(), surface.samples.begin() + static_cast<std::ptrdiff_t>(taken));
    std::sort(samples.begin(), samples.end());
    return samples;
}

double plane_distance(const ScanSurface& source, const ScanSurface& target,
                      const Rigid3& target_from_source, const Match& match) {
    return target.normals[match.target].dot(target_from_source * source.points[match.source] -
                                            target.points[match.target]);
}

double overlap_rms_mm(const SurfaceList& surfaces, const std::vector<Rigid3>& world_from_scan,
                      std::size_t sample_count, const MatchGates& gates) {
    double sum = 0;
    std::size_t count = 0;
    std::vector<std::uint32_t> warm;
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        const std::vector<std::uint32_t> samples = ordered_samples(*surfaces[i], sample_count);
        for (std::size_t j = 0; j < surfaces.size(); ++j) {
            if (i == j) continue;
            const Rigid3 target_from_source = world_from_scan[j].inverse() * world_from_scan[i];
            warm.clear();
            for (const Match& match : find_matches(*surfaces[i], *surfaces[j], target_from_source,
                                                   gates, samples, warm)) {
                sum += std::pow(
                    plane_distance(*surfaces[i], *surfaces[j], target_from_source, match), 2);
                ++count;
            }
        }
    }
    return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

}  // namespace stria
