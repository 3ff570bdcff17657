#include "host/registration/coarse.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "host/geometry/parallel.h"
#include "tests/support/bumpy_shape.h"

namespace stria {
namespace {

using Eigen::Vector3d;
constexpr double kDeg = 0.017453292519943295;

struct Views {
    std::vector<Rigid3> truth;
    std::vector<ScanSurface> scans;
};

Views take_views(unsigned shape_seed, int count, std::mt19937& rng) {
    const SurfaceTree shape(testing::make_bumpy_shape(shape_seed, 5));
    std::uniform_real_distribution<double> roll(-3.1, 3.1);
    Views views;
    for (const Vector3d& direction : testing::spread_directions(count)) {
        views.truth.push_back(testing::looking_from(direction, 300, roll(rng)));
        views.scans.push_back(prepare_surface(testing::take_view(
            shape, views.truth.back(),
            {.width = 130, .height = 130, .pitch_mm = 0.9, .sigma_mm = 0.03}, rng)));
    }
    return views;
}

/// Greatest turn (rad) of a placed scan against the truth, both seen from the first placed scan.
double greatest_error(const Views& views, const CoarseResult& result) {
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

TEST(PlaceScans, PutsViewsFromAllSidesTogetherByShapeAlone) {
    for (const unsigned shape : {1U, 2U, 3U}) {
        std::mt19937 rng(shape);
        const Views views = take_views(shape, 10, rng);
        const CoarseResult result = place_scans(views.scans);
        EXPECT_TRUE(result.all_placed) << shape;
        EXPECT_LT(greatest_error(views, result) / kDeg, 1.5) << shape;
    }
}

TEST(PlaceScans, IsTheSameForAnyThreadCount) {
    std::mt19937 rng(4);
    const Views views = take_views(4, 6, rng);
    set_thread_count(1);
    const CoarseResult one = place_scans(views.scans);
    set_thread_count(2);
    const CoarseResult two = place_scans(views.scans);
    set_thread_count(0);
    ASSERT_EQ(one.pairs.size(), two.pairs.size());
    for (std::size_t i = 0; i < one.scans.size(); ++i) {
        EXPECT_EQ(one.scans[i].placed, two.scans[i].placed);
        EXPECT_EQ(one.scans[i].world_from_scan.rotation, two.scans[i].world_from_scan.rotation);
    }
}

TEST(PlaceScans, SaysThatAScanOfAnotherPartCannotBePlaced) {
    std::mt19937 rng(5);
    Views views = take_views(5, 8, rng);
    Views other = take_views(6, 8, rng);
    views.scans[3] = std::move(other.scans[3]);
    const CoarseResult result = place_scans(views.scans);
    EXPECT_FALSE(result.all_placed);
    for (std::size_t i = 0; i < result.scans.size(); ++i)
        EXPECT_EQ(result.scans[i].placed, i != 3) << i << " " << result.scans[i].reason;
    EXPECT_FALSE(result.scans[3].reason.empty());
    EXPECT_LT(greatest_error(views, result) / kDeg, 1.5);
}

TEST(PlaceScans, AnswersDegenerateInput) {
    EXPECT_TRUE(place_scans({}).scans.empty());
    std::vector<ScanSurface> scans;
    scans.push_back(prepare_surface(make_range_image(0, 0)));
    EXPECT_EQ(place_scans(scans).scans[0].reason, "it has no surface");
    RangeImage plane = make_range_image(80, 80);
    for (int y = 0; y < 80; ++y)
        for (int x = 0; x < 80; ++x) {
            plane.mask[plane.cell(x, y)] = 1;
            plane.points[plane.cell(x, y)].position = Vector3d(x, -y, 0);
        }
    scans.push_back(prepare_surface(plane));
    scans.push_back(prepare_surface(plane));
    const CoarseResult result = place_scans(scans);
    EXPECT_FALSE(result.all_placed);  // two planes fit in many ways, so in none
    EXPECT_FALSE(result.scans[1].placed);
    EXPECT_THROW(place_scans(scans, {.min_overlap = 2}), std::invalid_argument);
}

}  // namespace
}  // namespace stria
