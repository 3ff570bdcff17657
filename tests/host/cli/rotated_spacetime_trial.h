#pragma once
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/host/cli/edge_cards.h"

namespace stria::test_support {

/// Renders the cards once, prints the errors of every way and holds spacetime along exact paths
/// against the others at 10:1 edges.
inline void expect_exact_paths_win(const EdgeCards& cards) {
    const RecordingContents sweep = sweep_of(cards);
    const auto tangents = rotation_tangents(cards);
    std::printf("%s, sigma_p / sigma_b %.2f, tan(theta_ST) %.4f, %zu frames\n",
                name_of(cards.scene.channel.axis.kind), cards.footprint_ratio, tangents[0],
                sweep.frames.size());
    EXPECT_NEAR(tangents[0] / tangents[1], 1, 0.05);  // the formula is of an orthographic camera
    const EdgeErrors cog = judge(spatial_crossings(sweep, PeakMethod::centre_of_gravity), cards);
    const EdgeErrors ml = judge(spatial_crossings(sweep, PeakMethod::maximum_likelihood), cards);
    const EdgeErrors rotated = judge(rotated_crossings(sweep, cards), cards);
    const EdgeErrors straight = judge(straight_crossings(sweep, cards), cards);
    const EdgeErrors exact = judge(path_crossings(sweep, cards), cards);
    print("spatial, centre of gravity", cog);
    print("spatial, maximum likelihood", ml);
    print("rotated spacetime image, one angle", rotated);
    print("one straight path, maximum likelihood", straight);
    print("exact paths, maximum likelihood", exact);
    EXPECT_GT(exact.points, 500U);
    EXPECT_LE(cards.footprint_ratio, 0.31);
    for (const EdgeErrors* spatial : {&cog, &ml}) {  // 60 % less
        EXPECT_LT(exact.worst_mm, 0.4 * spatial->worst_mm);
        EXPECT_LT(exact.rms_mm, 0.4 * spatial->rms_mm);
    }
    for (const EdgeErrors* peer : {&rotated, &straight}) {
        EXPECT_LT(exact.worst_mm, peer->worst_mm);
        EXPECT_LT(exact.rms_mm, peer->rms_mm);
    }
}

}  // namespace stria::test_support
