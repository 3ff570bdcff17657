#include "calib/degeneracies.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>

#include "firmware/core/angle.h"
#include "host/core/errors.h"
#include "tests/calib/synthetic_board.h"
#include "tests/calib/synthetic_scanner.h"

namespace stria {
namespace {

SyntheticOptions quick_views(MachineKind kind) {
    SyntheticOptions options;
    options.views = 10;
    options.pixel_step = 24;
    options.frames = 40;
    if (kind != MachineKind::swept) options.pictures = 5;
    return options;
}

/// One machine as built, and views of a board by it.
struct Bench {
    Bench(MachineKind kind, unsigned seed, const char* board_text = "chessboard:12x9:22")
        : rng(seed),
          board(parse_board(board_text)),
          drawn(drawn_scanner(kind)),
          truth(built_scanner(drawn, rng)),
          options(quick_views(kind)) {}

    /// The board's middle there, turned in its plane by roll, then tilted.
    void add(const Eigen::Vector3d& middle, const Eigen::Vector3d& tilt, double roll) {
        const auto points = board_points(board);
        const Eigen::Matrix3d rotation =
            rotation_from_vector(tilt) * rotation_from_vector({0, 0, roll});
        const Rigid3 pose{rotation, middle - rotation * (0.5 * (points.front() + points.back()))};
        views.push_back(synthetic_view(truth, board, pose, "view " + std::to_string(views.size()),
                                       options, rng));
    }
    /// Random views, n of them.
    void add_random(int n) {
        options.views = n;
        for (auto& view : synthetic_views(truth, board, options, rng))
            views.push_back(std::move(view));
    }
    double between(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(rng);
    }

    std::mt19937 rng;
    Board board;
    ScannerModel drawn, truth;
    SyntheticOptions options;
    std::vector<CornerView> views;
};

std::string names(const std::vector<DegeneracyFinding>& findings) {
    std::string text;
    for (const auto& found : findings)
        text += std::string(text.empty() ? "" : ", ") + name_of(found.kind);
    return text;
}

void multiply_axis(std::vector<CornerView>& views, double factor) {
    for (CornerView& view : views) {
        for (BoardCorners& seen : view.corners) seen.s *= factor;
        for (Pulse& pulse : view.pulses.pulses) pulse.s *= factor;
    }
}

struct DegenerateSet {
    Degeneracy kind;
    std::function<Bench(unsigned seed)> make;
};

Bench facing_boards(unsigned seed) {
    Bench bench(MachineKind::rail, seed);
    for (int i = 0; i < 8; ++i)
        bench.add({bench.between(-50, 50), bench.between(-40, 40), bench.between(420, 580)},
                  {bench.between(-0.06, 0.06), bench.between(-0.06, 0.06), 0},
                  bench.between(-3, 3));
    return bench;
}

Bench parallel_boards(unsigned seed) {
    Bench bench(MachineKind::swept, seed);
    for (int i = 0; i < 8; ++i)
        bench.add({bench.between(-50, 50), bench.between(-40, 40), bench.between(420, 580)},
                  {0.5, 0.1, 0}, bench.between(-3, 3));
    return bench;
}

Bench one_depth(unsigned seed) {
    Bench bench(MachineKind::swept, seed, "chessboard:12x9:12");
    for (int i = 0; i < 12; ++i)
        bench.add({bench.between(-150, 150), bench.between(-120, 120), 500},
                  {bench.between(-0.3, 0.3), bench.between(-0.3, 0.3), 0}, bench.between(-3, 3));
    return bench;
}

Bench centre_only(unsigned seed) {
    Bench bench(MachineKind::swept, seed, "chessboard:12x9:8");
    for (int i = 0; i < 12; ++i)
        bench.add({bench.between(-20, 20), bench.between(-15, 15), bench.between(420, 580)},
                  {bench.between(-0.5, 0.5), bench.between(-0.5, 0.5), 0}, bench.between(-3, 3));
    return bench;
}

/// The pulses with |s| at most that.
PulseMap swept_only(const PulseMap& all, double most) {
    PulseMap kept = all;
    kept.pulses.clear();
    kept.cell_begin = {0};
    for (std::size_t cell = 0; cell + 1 < all.cell_begin.size(); ++cell) {
        for (std::uint32_t i = all.cell_begin[cell]; i < all.cell_begin[cell + 1]; ++i)
            if (std::abs(all.pulses[i].s) <= most) kept.pulses.push_back(all.pulses[i]);
        kept.cell_begin.push_back(static_cast<std::uint32_t>(kept.pulses.size()));
    }
    return kept;
}

/// Boards turned about one line of the sheet, and sweeps that hardly leave it.
Bench one_stripe_line(unsigned seed) {
    Bench bench(MachineKind::rail, seed);
    const LaserSheet& sheet = bench.truth.channels[0].sheet;
    const double x = (sheet.offset_mm - 500 * sheet.normal.z()) / sheet.normal.x();
    const Eigen::Vector3d line = sheet.normal.cross(Eigen::Vector3d::UnitZ()).normalized();
    for (int i = 0; i < 10; ++i) {
        bench.add(Eigen::Vector3d(x, 0, 500), (-0.6 + 0.12 * i) * line,
                  i % 2 ? 0 : std::numbers::pi);
        bench.views.back().pulses = swept_only(bench.views.back().pulses, 5);
    }
    return bench;
}

Bench at_one_position(unsigned seed) {
    Bench bench(MachineKind::rail, seed);
    bench.options.pictures = 1;  // with the head at -120 mm, where it sees 120 mm to the left
    for (int i = 0; i < 12; ++i)
        bench.add(
            {-120 + bench.between(-130, 130), bench.between(-80, 80), bench.between(420, 580)},
            {bench.between(-0.5, 0.5), bench.between(-0.5, 0.5), 0}, bench.between(-3, 3));
    return bench;
}

Bench part_of_travel(MachineKind kind, double share, unsigned seed) {
    Bench bench(kind, seed);
    bench.options.travel_share = share;
    bench.add_random(10);
    return bench;
}

Bench few_views(int different, int copies, unsigned seed) {
    Bench bench(MachineKind::turntable, seed);
    bench.add_random(different);
    const auto once = bench.views;
    for (int i = 1; i < copies; ++i)
        bench.views.insert(bench.views.end(), once.begin(), once.end());
    return bench;
}

/// The board stated with squares 6 % too large: as when a print was fitted to the page.
Bench wrong_square(unsigned seed) {
    Bench bench(MachineKind::rail, seed);
    bench.add_random(10);
    bench.board = parse_board("chessboard:12x9:23.3");
    return bench;
}

Bench wrong_steps(MachineKind kind, double factor, unsigned seed) {
    Bench bench(kind, seed);
    bench.add_random(10);
    multiply_axis(bench.views, factor);
    return bench;
}

std::vector<DegenerateSet> degenerate_sets() {
    using enum Degeneracy;
    return {
        {one_view, [](unsigned seed) { return few_views(1, 1, seed); }},
        {too_few_views, [](unsigned seed) { return few_views(2, 1, seed); }},
        {same_view, [](unsigned seed) { return few_views(1, 6, seed); }},
        {no_tilt, facing_boards},
        {parallel_boards, stria::parallel_boards},
        {one_depth, stria::one_depth},
        {centre_only, stria::centre_only},
        {one_stripe_line, stria::one_stripe_line},
        {axis_unobservable, at_one_position},
        {short_arc,
         [](unsigned seed) { return part_of_travel(MachineKind::turntable, 0.4, seed); }},
        {short_travel, [](unsigned seed) { return part_of_travel(MachineKind::rail, 0.06, seed); }},
        {square_size, wrong_square},
        {axis_constant, [](unsigned seed) { return wrong_steps(MachineKind::turntable, 2, seed); }},
        {axis_constant, [](unsigned seed) { return wrong_steps(MachineKind::rail, 0.5, seed); }},
        {axis_constant, [](unsigned seed) { return wrong_steps(MachineKind::swept, 2, seed); }},
    };
}

TEST(Degeneracies, EveryInjectedOneIsNamedAndNoOther) {
    for (const DegenerateSet& set : degenerate_sets()) {
        const Bench bench = set.make(7);
        const auto found = find_degeneracies(bench.views, bench.board, bench.drawn);
        EXPECT_EQ(names(found), name_of(set.kind));
    }
}

TEST(Degeneracies, GoodRandomViewsAreNotBlamed) {
    const int sets = STRIA_GOOD_SETS;
    for (int i = 0; i < sets; ++i) {
        Bench bench(MachineKind(i % 3), 100U + static_cast<unsigned>(i));
        bench.add_random(15);
        EXPECT_EQ(names(find_degeneracies(bench.views, bench.board, bench.drawn)), "")
            << name_of(MachineKind(i % 3)) << " seed " << 100 + i;
    }
}

TEST(Degeneracies, NothingIsSaidWhereNoBoardIsSeen) {
    const Bench bench(MachineKind::rail, 1);
    EXPECT_TRUE(find_degeneracies({}, bench.board, bench.drawn).empty());
    EXPECT_TRUE(find_degeneracies({CornerView{}}, bench.board, bench.drawn).empty());
}

TEST(Degeneracies, AMachineThatLeftItsDrawingIsAContradiction) {
    const ScannerModel drawn = drawn_scanner(MachineKind::swept);
    ScannerModel solved = drawn;
    EXPECT_TRUE(find_contradictions(solved, drawn, 10).empty());
    solved.channels[0].axis.mirror.point *= 1.3;  // 202 mm: 61 mm away
    EXPECT_EQ(names(find_contradictions(solved, drawn, 10)), "square size");
    EXPECT_TRUE(find_contradictions(solved, drawn, 20).empty());
}

}  // namespace
}  // namespace stria
