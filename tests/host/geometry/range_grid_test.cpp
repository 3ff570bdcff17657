#include "host/geometry/range_grid.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <deque>
#include <map>
#include <random>
#include <set>

namespace stria {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// Orthographic grid of 1 mm pitch over z(x, y); `step_y` -1 lets rows run downwards.
template <typename Height>
RangeImage height_field(int width, int height, double step_y, Height z) {
    RangeImage image = make_range_image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            image.mask[image.cell(x, y)] = 1;
            image.points[image.cell(x, y)].position = {double(x), step_y * y, z(x, step_y * y)};
        }
    return image;
}

RangeImage plane(int width, int height, double step_y = 1) {
    return height_field(width, height, step_y, [](double x, double) { return 0.5 * x; });
}

Eigen::Vector3d area_vector(const RangeImage& image, const std::array<std::uint32_t, 3>& t) {
    const Eigen::Vector3d& a = image.points[t[0]].position;
    return 0.5 * (image.points[t[1]].position - a).cross(image.points[t[2]].position - a);
}

TEST(RangeTriangles, CoverAFullGridOnceWhicheverWayItsRowsRun) {
    for (const double step_y : {1.0, -1.0}) {
        const RangeImage image = plane(7, 5, step_y);
        const Triangles triangles = range_triangles(image);
        ASSERT_EQ(triangles.size(), 6u * 4u * 2u);
        double seen_area = 0;
        for (const auto& t : triangles) {
            EXPECT_GT(area_vector(image, t).z(), 0);  // counter-clockwise seen from +z
            seen_area += area_vector(image, t).z();
        }
        EXPECT_NEAR(seen_area, 6 * 4, 1e-12);  // mm2, rounding
    }
}

TEST(RangeTriangles, FaceTheCameraOfEachStation) {
    RangeImage image = plane(6, 6);
    for (RangePoint& point : image.points) point.s = point.position.x();
    image.stations = {{.s = 0, .camera_in_scan = {0, 0, -300}},  // seen from below
                      {.s = 5, .camera_in_scan = {5, 0, -300}}};
    for (const auto& t : range_triangles(image)) EXPECT_LT(area_vector(image, t).z(), 0);
}

TEST(RangeTriangles, TakeTheShorterDiagonalAndLeaveLongEdgesOut) {
    RangeImage image = plane(2, 2);
    image.points[image.cell(1, 1)].position.z() += 9;  // a step at one corner
    const Triangles triangles = range_triangles(image, {.max_edge_mm = 3});
    ASSERT_EQ(triangles.size(), 1u);
    const std::set<std::uint32_t> cells(triangles[0].begin(), triangles[0].end());
    EXPECT_EQ(cells, (std::set<std::uint32_t>{0, 1, 2}));
}

TEST(RangeTriangles, MakeOneTriangleOfThreeCorners) {
    for (std::uint32_t missing = 0; missing < 4; ++missing) {
        RangeImage image = plane(2, 2);
        image.mask[missing] = 0;
        const Triangles triangles = range_triangles(image);
        ASSERT_EQ(triangles.size(), 1u) << missing;
        for (const std::uint32_t cell : triangles[0]) EXPECT_NE(cell, missing);
    }
}

TEST(RangeTriangles, LeaveFlatAndBackFacingOnesOut) {
    // A fold: column 2 lies left of column 1, so the strip between them faces away.
    RangeImage image = plane(6, 4);
    for (int y = 0; y < 4; ++y) image.points[image.cell(2, y)].position.x() = 0.5;
    for (const auto& t : range_triangles(image, {.max_edge_mm = 10}))
        EXPECT_GT(area_vector(image, t).z(), 0);
    const RangeImage steep = height_field(4, 4, 1, [](double x, double) { return 5 * x; });
    EXPECT_TRUE(range_triangles(steep, {.max_incidence_rad = std::atan(5.0) - 0.01}).empty());
    EXPECT_EQ(range_triangles(steep, {.max_incidence_rad = std::atan(5.0) + 0.01}).size(), 18u);
}

TEST(RangeTriangles, OfAnEmptyOrTinyImageAreNone) {
    EXPECT_TRUE(range_triangles(make_range_image(0, 0)).empty());
    EXPECT_TRUE(range_triangles(make_range_image(5, 5)).empty());
    EXPECT_TRUE(range_triangles(plane(1, 9)).empty());
    EXPECT_EQ(median_pitch_mm(make_range_image(5, 5)), 0);
}

TEST(MedianPitch, IsThatOfMostNeighbours) {
    RangeImage image = height_field(20, 20, 1, [](double, double) { return 0.0; });
    image.points[50].position.z() = 100;
    EXPECT_DOUBLE_EQ(median_pitch_mm(image), 1);
}

/// The obvious way: a graph with a map of edges, breadth first from edges used once.
std::vector<std::uint16_t> slow_border_distance(const RangeImage& image, const Triangles& triangles,
                                                int cap) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
    std::map<std::uint32_t, std::set<std::uint32_t>> neighbours;
    for (const auto& t : triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [a, b] = std::minmax(t[k], t[(k + 1) % 3]);
            ++uses[{a, b}];
            neighbours[a].insert(b);
            neighbours[b].insert(a);
        }
    std::vector<std::uint16_t> distance(image.cell_count(), static_cast<std::uint16_t>(cap));
    for (std::uint32_t c = 0; c < distance.size(); ++c)
        if (!neighbours.count(c)) distance[c] = 0;
    for (const auto& [edge, count] : uses)
        if (count == 1) distance[edge.first] = distance[edge.second] = 0;
    std::deque<std::uint32_t> queue;
    for (const auto& [cell, list] : neighbours)
        if (distance[cell] == 0) queue.push_back(cell);
    for (; !queue.empty(); queue.pop_front())
        for (const std::uint32_t n : neighbours[queue.front()])
            if (distance[n] > distance[queue.front()] + 1) {
                distance[n] = static_cast<std::uint16_t>(distance[queue.front()] + 1);
                queue.push_back(n);
            }
    return distance;
}

TEST(BorderDistance, EqualsThatOfAGraphSearch) {
    std::mt19937 rng(11);
    for (int trial = 0; trial < 60; ++trial) {
        const int width = 2 + static_cast<int>(rng() % 20),
                  height = 2 + static_cast<int>(rng() % 20);
        RangeImage image = height_field(width, height, 1, [&](double, double) {
            return 0.3 * static_cast<double>(rng() % 100) / 100;
        });
        for (std::uint8_t& m : image.mask) m = rng() % 25 != 0;
        const Triangles triangles = range_triangles(image, {.max_edge_mm = 3});
        for (const int cap : {4, 32})
            ASSERT_EQ(border_distance(image, triangles, cap),
                      slow_border_distance(image, triangles, cap))
                << trial << " " << width << " x " << height;
    }
}

TEST(BorderDistance, GrowsTowardsTheMiddleUpToTheCap) {
    const RangeImage image = plane(21, 21);
    const auto distance = border_distance(image, range_triangles(image), 6);
    for (int y = 0; y < 21; ++y)
        for (int x = 0; x < 21; ++x)
            EXPECT_LE(distance[image.cell(x, y)], std::min({x, y, 20 - x, 20 - y, 6}) * 2);
    EXPECT_EQ(distance[image.cell(10, 10)], 6);
    EXPECT_EQ(distance[image.cell(0, 10)], 0);
}

TEST(ComputeNormals, AreThoseOfThePlane) {
    RangeImage image = plane(6, 6, -1);
    image.mask[image.cell(5, 5)] = 0;
    compute_normals(image, range_triangles(image));
    const Eigen::Vector3f expected = Eigen::Vector3d(-0.5, 0, 1).normalized().cast<float>();
    for (std::size_t c = 0; c + 1 < image.cell_count(); ++c)
        EXPECT_LT((image.points[c].normal - expected).norm(), 1e-6f);  // float rounding
    EXPECT_EQ(image.points.back().normal, Eigen::Vector3f::Zero());
}

TEST(ComputeNormals, FollowASphere) {
    const double radius = 50;
    RangeImage image = height_field(41, 41, 1, [&](double x, double y) {
        return std::sqrt(radius * radius - (x - 20) * (x - 20) - (y - 20) * (y - 20));
    });
    compute_normals(image, range_triangles(image));
    for (int y = 1; y < 40; ++y)
        for (int x = 1; x < 40; ++x) {
            const RangePoint& point = image.at(x, y);
            const Eigen::Vector3d radial = (point.position - Eigen::Vector3d(20, 20, 0)) / radius;
            // A chord of 1 mm on a 50 mm sphere turns by 0.02 rad; one-sided fans err by half.
            EXPECT_LT((point.normal.cast<double>() - radial).norm(), 0.01);
        }
}

}  // namespace
}  // namespace stria
