#include "tests/host/cli/rotated_spacetime_trial.h"

/// Spacetime along exact paths, the rotated spacetime image and spatial peaks at 10:1 edges.
namespace stria::test_support {
namespace {

TEST(PathsAtEdges, Rail) { expect_exact_paths_win(edge_cards(MachineKind::rail, 60, 0)); }
TEST(PathsAtEdges, RailWithABlurredLens) {
    expect_exact_paths_win(edge_cards(MachineKind::rail, 60, 0.4));
}
TEST(PathsAtEdges, Turntable) { expect_exact_paths_win(edge_cards(MachineKind::turntable, 60, 0)); }
TEST(PathsAtEdges, TurntableWithABlurredLens) {
    expect_exact_paths_win(edge_cards(MachineKind::turntable, 60, 0.4));
}

}  // namespace
}  // namespace stria::test_support
