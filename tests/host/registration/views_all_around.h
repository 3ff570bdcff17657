#pragma once
#include <random>
#include <vector>

#include "host/registration/coarse.h"
#include "tests/support/bumpy_shape.h"

/// Scans of a lumpy shape from all around, their poses kept as the truth.
namespace stria::testing {

struct Views {
    std::vector<Rigid3> truth;
    std::vector<ScanSurface> scans;
};

inline Views take_views(unsigned shape_seed, int count, std::mt19937& rng) {
    const SurfaceTree shape(make_bumpy_shape(shape_seed, 5));
    std::uniform_real_distribution<double> roll(-3.1, 3.1);
    Views views;
    for (const Eigen::Vector3d& direction : spread_directions(count)) {
        views.truth.push_back(looking_from(direction, 300, roll(rng)));
        views.scans.push_back(prepare_surface(
            take_view(shape, views.truth.back(),
                      {.width = 130, .height = 130, .pitch_mm = 0.9, .sigma_mm = 0.03}, rng)));
    }
    return views;
}

/// Greatest turn (rad) of a placed scan against the truth, both seen from the first placed scan.
inline double greatest_error(const Views& views, const CoarseResult& result) {
    std::size_t first = 0;
    while (first < result.scans.size() && !result.scans[first].placed) ++first;
    double worst = 0;
    for (std::size_t i = first; i < result.scans.size(); ++i) {
        if (!result.scans[i].placed) continue;
        const Rigid3 truth = views.truth[first].inverse() * views.truth[i];
        const Rigid3& found = result.scans[i].world_from_scan;
        worst = std::max(worst,
                         vector_from_rotation(found.rotation * truth.rotation.transpose()).norm());
    }
    return worst;
}

}  // namespace stria::testing
