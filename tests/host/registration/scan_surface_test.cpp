#include "host/registration/scan_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/bumpy_shape.h"

namespace stria {
namespace {

using Eigen::Vector3d;

RangeImage tilted_plane(int size) {  // z = 0.5 x, seen from +z
    RangeImage image = make_range_image(size, size);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            image.mask[image.cell(x, y)] = 1;
            image.points[image.cell(x, y)].position = Vector3d(x, -y, 0.5 * x);
        }
    return image;
}

TEST(ScanSurface, HasTheNormalsAndBordersOfAPlane) {
    const ScanSurface surface = prepare_surface(tilted_plane(20));
    ASSERT_EQ(surface.points.size(), 400U);
    const Vector3d normal = Vector3d(-0.5, 0, 1).normalized();
    int border = 0;
    for (std::size_t i = 0; i < surface.points.size(); ++i) {
        EXPECT_LT((surface.normals[i] - normal).norm(), 1e-12);
        EXPECT_EQ(surface.to_camera[i], Vector3d::UnitZ());
        border += surface.is_border[i];
    }
    EXPECT_EQ(border, 4 * 19);
    EXPECT_EQ(surface.samples.size(), 16U * 16U);  // two cells from each border left out
    EXPECT_TRUE(surface.sigma_mm.empty());
    EXPECT_LT((surface.centre - Vector3d(9.5, -9.5, 4.75)).norm(), 1e-12);
}

TEST(ScanSurface, ProjectsSigmaOnTheNormal) {
    RangeImage image = tilted_plane(20);
    for (RangePoint& point : image.points) {
        point.error_direction = -Eigen::Vector3f::UnitZ();
        point.sigma_mm = 0.1F;
    }
    const ScanSurface surface = prepare_surface(image);
    ASSERT_EQ(surface.sigma_mm.size(), 400U);
    for (const double sigma : surface.sigma_mm) EXPECT_NEAR(sigma, 0.1 / std::sqrt(1.25), 1e-6);
}

TEST(ScanSurface, AnyFirstPartOfTheSamplesIsEven) {
    std::mt19937 rng(1);
    const SurfaceTree shape(testing::make_bumpy_shape(1, 4));
    const RangeImage image =
        testing::take_view(shape, testing::looking_from(Vector3d(1, 2, 3), 300), {}, rng);
    const ScanSurface surface = prepare_surface(image);
    // Halves of the picture hold the same share of the first n samples as of all.
    const auto share = [&](std::size_t count, int axis) {
        double n = 0;
        for (std::size_t i = 0; i < count; ++i)
            n += surface.points[surface.samples[i]][axis] < surface.centre[axis];
        return n / static_cast<double>(count);
    };
    for (const std::size_t count : {500U, 2000U})
        for (int axis = 0; axis < 2; ++axis)
            EXPECT_NEAR(share(count, axis), share(surface.samples.size(), axis), 0.03);
}

TEST(ScanSurface, PassesOverWhatIsNotFiniteOrNoSurface) {
    RangeImage image = tilted_plane(20);
    image.points[image.cell(5, 5)].position.z() = std::nan("");
    const ScanSurface surface = prepare_surface(image);
    EXPECT_EQ(surface.points.size(), 399U);
    for (const Vector3d& normal : surface.normals) EXPECT_NEAR(normal.norm(), 1.0, 1e-12);

    EXPECT_TRUE(prepare_surface(make_range_image(10, 10)).points.empty());
    EXPECT_TRUE(prepare_surface(make_range_image(0, 0)).samples.empty());
    RangeImage single = make_range_image(3, 3);
    single.mask[4] = 1;
    EXPECT_TRUE(prepare_surface(single).points.empty());
}

}  // namespace
}  // namespace stria
