#include <gtest/gtest.h>

#include <stdexcept>

#include "firmware/core/angle.h"
#include "host/geometry/parallel.h"
#include "tests/host/registration/views_all_around.h"

namespace stria {
namespace {

using Eigen::Vector3d;
using testing::greatest_error;
using testing::take_views;
using testing::Views;

TEST(PlaceScans, IsTheSameForAnyThreadCount) {
    std::mt19937 rng(4);
    const Views views = take_views(4, 3, rng);
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
    EXPECT_LT(greatest_error(views, result) / kDegree, 1.5);
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
