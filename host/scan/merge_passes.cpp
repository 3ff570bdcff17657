#include "host/scan/merge_passes.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "host/core/errors.h"
#include "host/scan/compare_directions.h"

namespace stria {
namespace {

/// Pulses of different passes that are one.
struct Cluster {
    Pulse best;
    double weight = 0, weighted_s = 0;
    std::vector<std::size_t> passes;

    double s() const { return weighted_s / weight; }
    double sigma() const { return 1 / std::sqrt(weight); }
    bool holds(std::size_t pass) const {
        return std::find(passes.begin(), passes.end(), pass) != passes.end();
    }
    void add(const Pulse& pulse, std::size_t pass) {
        const double sigma = sigma_of_s(pulse);
        weight += 1 / (sigma * sigma);
        weighted_s += pulse.s / (sigma * sigma);
        passes.push_back(pass);
    }
};

struct Seen {
    Pulse pulse;
    std::size_t pass = 0;
};

bool can_merge(const Pulse& pulse) {
    return sigma_of_s(pulse) > 0 && (pulse.flags & kPulseSpatialFallback) == 0;
}

/// The most precise first; then each joins the nearest cluster that lacks its pass.
std::vector<Cluster> clusters_of(std::vector<Seen>& seen, double axis_sigma_s) {
    std::stable_sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) {
        return sigma_of_s(a.pulse) < sigma_of_s(b.pulse);
    });
    std::vector<Cluster> clusters;
    for (const auto& [pulse, pass] : seen) {
        Cluster* nearest = nullptr;
        double least = kSamePlace;
        for (Cluster& cluster : clusters) {
            if (cluster.holds(pass) || !same_pixel(cluster.best, pulse)) continue;
            const double off =
                std::abs(pulse.s - cluster.s()) /
                std::hypot(cluster.sigma(), sigma_of_s(pulse), std::sqrt(2.0) * axis_sigma_s);
            if (off > least) continue;
            least = off;
            nearest = &cluster;
        }
        if (!nearest) {
            nearest = &clusters.emplace_back();
            nearest->best = pulse;
        }
        nearest->add(pulse, pass);
        nearest->best.flags |= pulse.flags & kPulseGhostSuspected;
    }
    return clusters;
}

std::vector<Pulse> merged(std::vector<Seen> seen, double axis_sigma_s) {
    std::vector<Pulse> pulses;
    std::vector<Seen> mergeable;
    for (const Seen& one : seen)
        if (can_merge(one.pulse))
            mergeable.push_back(one);
        else
            pulses.push_back(one.pulse);
    for (const Cluster& cluster : clusters_of(mergeable, axis_sigma_s)) {
        Pulse pulse = cluster.best;
        if (cluster.passes.size() > 1) {
            pulse.s = cluster.s();
            pulse.sigma = static_cast<float>(cluster.sigma() / (1e-9 * std::abs(pulse.ds_dt)));
        }
        pulses.push_back(pulse);
    }
    return pulses;
}

/// An empty map of the passes' common grid, with their sums.
PulseMap common_grid(std::span<const PulseMap> passes, PassGrid grid, const std::string& name) {
    PulseMap all = passes.front();
    for (const PulseMap& map : passes.subspan(1)) {
        if (map.height != all.height || map.mode != all.mode ||
            (map.width != all.width && grid == PassGrid::image))
            throw Error(name + ": holds sweeps of different grids: " + std::to_string(all.width) +
                        " x " + std::to_string(all.height) + " and " + std::to_string(map.width) +
                        " x " + std::to_string(map.height));
        all.width = std::max(all.width, map.width);
        all.frames += map.frames;
        all.frames_dropped += map.frames_dropped;
        all.saturated_samples += map.saturated_samples;
        all.undersampled = all.undersampled || map.undersampled;
    }
    all.pulses.clear();
    all.cell_begin.assign(1, 0);
    return all;
}

/// The pulses of a cell; none beyond the frames of a pass that has fewer.
std::span<const Pulse> cell_of(const PulseMap& map, PassGrid grid, int x, int y) {
    if (x >= map.width) return {};
    const bool goes_back = !map.pulses.empty() && map.pulses.front().ds_dt < 0;
    return map.cell(grid == PassGrid::frames && goes_back ? map.width - 1 - x : x, y);
}

/// Those suspected as ghosts give way first.
void keep_strongest(std::vector<Pulse>& pulses) {
    const auto stronger = [](const Pulse& a, const Pulse& b) { return a.amplitude > b.amplitude; };
    std::stable_sort(pulses.begin(), pulses.end(), stronger);
    if (pulses.size() <= kMaxPulsesPerCell) return;
    std::stable_partition(pulses.begin(), pulses.end(),
                          [](const Pulse& p) { return (p.flags & kPulseGhostSuspected) == 0; });
    pulses.resize(kMaxPulsesPerCell);
    std::stable_sort(pulses.begin(), pulses.end(), stronger);
}

}  // namespace

PulseMap merge_passes(std::span<const PulseMap> passes, PassGrid grid, const std::string& name,
                      double axis_sigma_s) {
    if (passes.size() == 1) return passes.front();
    PulseMap all = common_grid(passes, grid, name);
    for (int y = 0; y < all.height; ++y)
        for (int x = 0; x < all.width; ++x) {
            std::vector<Seen> seen;
            for (std::size_t pass = 0; pass < passes.size(); ++pass)
                for (const Pulse& pulse : cell_of(passes[pass], grid, x, y))
                    seen.push_back({pulse, pass});
            std::vector<Pulse> pulses;
            if (grid == PassGrid::image)
                pulses = merged(std::move(seen), axis_sigma_s);
            else
                for (const Seen& one : seen) pulses.push_back(one.pulse);
            keep_strongest(pulses);
            all.pulses.insert(all.pulses.end(), pulses.begin(), pulses.end());
            all.cell_begin.push_back(static_cast<std::uint32_t>(all.pulses.size()));
        }
    return all;
}

}  // namespace stria
