#include <gtest/gtest.h>

#include "firmware/core/angle.h"
#include "tests/host/registration/views_all_around.h"

namespace stria {
namespace {

using testing::greatest_error;
using testing::take_views;
using testing::Views;

TEST(PlaceScans, PutsViewsFromAllSidesTogetherByShapeAlone) {
    for (const unsigned shape : {1U, 2U, 3U}) {
        std::mt19937 rng(shape);
        const Views views = take_views(shape, 10, rng);
        const CoarseResult result = place_scans(views.scans);
        EXPECT_TRUE(result.all_placed) << shape;
        EXPECT_LT(greatest_error(views, result) / kDegree, 1.5) << shape;
    }
}

}  // namespace
}  // namespace stria
