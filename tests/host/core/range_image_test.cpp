#include "host/core/range_image.h"

#include <gtest/gtest.h>

#include "host/core/image.h"

namespace stria {
namespace {

TEST(RangeImage, StartsEmpty) {
    RangeImage image = make_range_image(4, 3);
    EXPECT_EQ(image.cell_count(), 12U);
    EXPECT_EQ(image.points.size(), 12U);
    EXPECT_EQ(valid_count(image), 0U);
    image.mask[image.cell(3, 1)] = 1;
    EXPECT_EQ(image.cell(3, 1), 7U);
    EXPECT_TRUE(image.has(3, 1));
    EXPECT_FALSE(image.has(1, 2));
    EXPECT_EQ(valid_count(image), 1U);
}

TEST(RangeImage, StationsAreLinearInBetweenAndConstantBeyond) {
    RangeImage image = make_range_image(1, 1);
    image.stations = {
        {0, {0, 0, 0}, {10, 0, 0}}, {2, {4, 0, 8}, {10, 2, 0}}, {3, {0, 0, 0}, {0, 0, 0}}};
    const Station half = station_at(image, 0.5);
    EXPECT_EQ(half.s, 0.5);
    EXPECT_LT((half.camera_in_scan - Eigen::Vector3d(1, 0, 2)).norm(), 1e-12);
    EXPECT_LT((half.laser_in_scan - Eigen::Vector3d(10, 0.5, 0)).norm(), 1e-12);
    EXPECT_EQ(station_at(image, 2).camera_in_scan, Eigen::Vector3d(4, 0, 8));
    EXPECT_EQ(station_at(image, -9).laser_in_scan, Eigen::Vector3d(10, 0, 0));
    EXPECT_EQ(station_at(image, 9).camera_in_scan, Eigen::Vector3d(0, 0, 0));
    image.stations.resize(1);
    EXPECT_EQ(station_at(image, 7).laser_in_scan, Eigen::Vector3d(10, 0, 0));
}

TEST(RangeImage, WithoutStationsIsSeenFromAbove) {
    RangeImage image = make_range_image(1, 1);
    RangePoint point;
    point.position = {1, 2, 3};
    EXPECT_EQ(direction_to_camera(image, point), Eigen::Vector3d::UnitZ());
    EXPECT_THROW(station_at(image, 0), std::invalid_argument);
    image.stations = {{0, {1, 2, 13}, {0, 0, 0}}};
    EXPECT_EQ(direction_to_camera(image, point), Eigen::Vector3d::UnitZ());
    image.stations[0].camera_in_scan = {1, -2, 3};
    EXPECT_EQ(direction_to_camera(image, point), -Eigen::Vector3d::UnitY());
}

TEST(Image, InterleavesChannelsRowByRow) {
    Image<std::uint8_t> image(4, 3, 3, 9);
    EXPECT_EQ(image.values.size(), 36U);
    image.at(2, 1, 1) = 7;
    EXPECT_EQ(image.values[(1 * 4 + 2) * 3 + 1], 7);
    EXPECT_EQ(image.at(0, 0, 0), 9);
    const GreyImage grey(5, 2, 1, 3);
    EXPECT_EQ(grey.view().at(4, 1), 3);
    EXPECT_TRUE(GreyImage().empty());
}

}  // namespace
}  // namespace stria
