#pragma once
#include <cstddef>

#include "host/scan/compare_directions.h"
#include "sim/scene.h"
#include "tests/sim/sim_sweep.h"

/// Sweeps there and back on the simulator whose scene may differ between the passes, rendered
/// frames with noise to range images, held against the surfaces that were there all the time.
namespace stria::test {

/// All frames of a pass of the scene's whole travel.
SimSweep sweep(const Scene& scene, unsigned seed, bool back);

/// What became of the points.
struct Outcome {
    DirectionComparison told;
    std::size_t right = 0, right_flagged = 0;  ///< and what of them carries a warning
    std::size_t wrong = 0, wrong_flagged = 0;
    /// Wrong without a warning, from twice the least amplitude that an analyser claims.
    std::size_t missed = 0;
    double wrong_flagged_share() const {
        return static_cast<double>(wrong_flagged) / static_cast<double>(wrong);
    }
    double right_flagged_share() const {
        return static_cast<double>(right_flagged) / static_cast<double>(right);
    }
};

/// The range image of two passes against the surfaces of the scenes that they saw. Wrong: off along
/// the ray by more than max(5 sigma, sigma_b / 2) in either: what stands still is in both.
Outcome outcome_of(const SimSweep& there, const Scene& seen_there, const SimSweep& back,
                   const Scene& seen_back);

}  // namespace stria::test
