#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "host/geometry/nearest.h"

namespace stria {
namespace {

using Eigen::Vector3d;

TriMesh random_triangles(std::mt19937& rng, int count) {
    std::uniform_real_distribution<double> mm(-10.0, 10.0), small(-2.0, 2.0);
    TriMesh mesh;
    for (int i = 0; i < count; ++i) {
        const Vector3d at(mm(rng), mm(rng), mm(rng));
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (int k = 0; k < 3; ++k)
            mesh.positions.push_back(at + Vector3d(small(rng), small(rng), small(rng)));
        if (i % 10 == 0) mesh.positions.back() = mesh.positions[first];      // a segment
        if (i % 50 == 0) mesh.positions[first + 1] = mesh.positions[first];  // a point
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

/// Distance to a triangle by the quadratic programme over its barycentric coordinates, solved by
/// visiting every face of the simplex: slow, independent of the tree's own way.
double slow_distance(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& p) {
    double best = std::min({(a - p).norm(), (b - p).norm(), (c - p).norm()});
    const auto segment = [&](const Vector3d& from, const Vector3d& to) {
        const Vector3d d = to - from;
        const double t = d.squaredNorm() > 0 ? d.dot(p - from) / d.squaredNorm() : 0.0;
        if (t > 0 && t < 1) best = std::min(best, (from + t * d - p).norm());
    };
    segment(a, b);
    segment(b, c);
    segment(c, a);
    Eigen::Matrix<double, 3, 2> span;
    span << b - a, c - a;
    const Eigen::Matrix2d gram = span.transpose() * span;
    if (gram.determinant() > 1e-20) {
        const Eigen::Vector2d vw = gram.inverse() * (span.transpose() * (p - a));
        if (vw.minCoeff() > 0 && vw.sum() < 1) best = std::min(best, (a + span * vw - p).norm());
    }
    return best;
}

TEST(SurfaceTree, NearestAgreesWithBruteForce) {
    std::mt19937 rng(1);
    std::uniform_real_distribution<double> mm(-15.0, 15.0);
    const TriMesh mesh = random_triangles(rng, 400);
    const SurfaceTree tree(mesh);
    for (int trial = 0; trial < 500; ++trial) {
        const Vector3d q(mm(rng), mm(rng), mm(rng));
        double expected = 1e300;
        for (const auto& t : mesh.triangles)
            expected = std::min(expected, slow_distance(mesh.positions[t[0]], mesh.positions[t[1]],
                                                        mesh.positions[t[2]], q));
        const auto hit = tree.nearest(q);
        ASSERT_TRUE(hit);
        ASSERT_NEAR(hit->distance_mm, expected, 1e-9) << q.transpose();  // mm, rounding
        const auto& t = mesh.triangles[hit->triangle];
        const Vector3d again = hit->barycentric[0] * mesh.positions[t[0]] +
                               hit->barycentric[1] * mesh.positions[t[1]] +
                               hit->barycentric[2] * mesh.positions[t[2]];
        ASSERT_LT((again - hit->point).norm(), 1e-12);
        ASSERT_GE(hit->barycentric.minCoeff(), 0.0);
        ASSERT_NEAR((hit->point - q).norm(), hit->distance_mm, 1e-12);
        ASSERT_FALSE(tree.nearest(q, 0.999 * expected));
        ASSERT_TRUE(tree.nearest(q, 1.001 * expected));
    }
}

TEST(SurfaceTree, FirstHitAgreesWithBruteForce) {
    std::mt19937 rng(2);
    std::uniform_real_distribution<double> mm(-15.0, 15.0);
    const TriMesh mesh = random_triangles(rng, 400);
    const SurfaceTree tree(mesh);
    int hits = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        const Vector3d origin(mm(rng), mm(rng), mm(rng));
        const Vector3d direction(mm(rng), mm(rng), mm(rng));
        double expected = 1e300;
        for (const auto& t : mesh.triangles) {  // solve o + t d = a + v ab + w ac
            const Vector3d a = mesh.positions[t[0]];
            Eigen::Matrix3d system;
            system << mesh.positions[t[1]] - a, mesh.positions[t[2]] - a, -direction;
            if (std::abs(system.determinant()) < 1e-12) continue;
            const Vector3d vwt = system.inverse() * (origin - a);
            if (vwt[0] >= 0 && vwt[1] >= 0 && vwt[0] + vwt[1] <= 1 && vwt[2] >= 0)
                expected = std::min(expected, vwt[2]);
        }
        const auto hit = tree.first_hit(origin, direction);
        ASSERT_EQ(hit.has_value(), expected < 1e300) << trial;
        if (!hit) continue;
        ++hits;
        ASSERT_NEAR(hit->t, expected, 1e-9 * (1 + expected));
        ASSERT_FALSE(tree.first_hit(origin, direction, 0, 0.999 * expected));
        const auto beyond = tree.first_hit(origin, direction, 1.001 * expected);
        ASSERT_TRUE(!beyond || beyond->t >= 1.001 * expected);
    }
    EXPECT_GT(hits, 200);
}

/// A closed sphere of latitude and longitude.
TriMesh sphere(int rings, int segments, double radius) {
    TriMesh mesh;
    for (int i = 0; i <= rings; ++i)
        for (int j = 0; j < segments; ++j) {
            const double theta = M_PI * i / rings, phi = 2 * M_PI * j / segments;
            const double across = i < rings ? std::sin(theta) : 0.0;  // else a hole of 1e-15 mm
            mesh.positions.push_back(
                radius * Vector3d(across * std::cos(phi), across * std::sin(phi), std::cos(theta)));
        }
    const auto at = [&](int i, int j) {
        return static_cast<std::uint32_t>(i * segments + j % segments);
    };
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < segments; ++j) {
            mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return mesh;
}

TEST(SurfaceTree, NoRaySlipsThroughTheSeamsOfAClosedMesh) {
    const TriMesh mesh = sphere(24, 48, 10.0);
    const SurfaceTree tree(mesh);
    std::mt19937 rng(3);
    std::uniform_real_distribution<double> u(0.0, 1.0);
    for (const auto& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {  // exactly at vertices and along edges
            const Vector3d& a = mesh.positions[t[k]];
            const Vector3d& b = mesh.positions[t[(k + 1) % 3]];
            ASSERT_TRUE(tree.first_hit(Vector3d::Zero(), a));
            ASSERT_TRUE(tree.first_hit(Vector3d::Zero(), a + u(rng) * (b - a)));
            ASSERT_TRUE(tree.first_hit(20.0 * a, -a));
        }
}

TEST(SurfaceTree, RaysAlongTheAxesHit) {
    TriMesh square;
    square.positions = {{-1, -1, 5}, {1, -1, 5}, {1, 1, 5}, {-1, 1, 5}};
    square.triangles = {{0, 1, 2}, {0, 2, 3}};
    const SurfaceTree tree(square);
    for (double x : {-1.0, -0.5, 0.0, 1.0})
        for (double y : {-1.0, 0.0, 0.5, 1.0}) {
            const auto hit = tree.first_hit(Vector3d(x, y, 0), Vector3d(0, 0, 2));
            ASSERT_TRUE(hit) << x << " " << y;
            ASSERT_EQ(hit->t, 2.5);
            ASSERT_TRUE(tree.first_hit(Vector3d(x, y, 9), Vector3d(0, 0, -1)));
            ASSERT_FALSE(tree.first_hit(Vector3d(x, y, 9), Vector3d(0, 0, 1)));
        }
    EXPECT_FALSE(tree.first_hit(Vector3d(-5, 0, 0), Vector3d::UnitX()));
    EXPECT_FALSE(tree.first_hit(Vector3d(1.0001, 0, 0), Vector3d::UnitZ()));
}

TEST(SurfaceTree, AnswersDegenerateInput) {
    const SurfaceTree empty{TriMesh{}};
    EXPECT_FALSE(empty.nearest(Vector3d::Zero()));
    EXPECT_FALSE(empty.first_hit(Vector3d::Zero(), Vector3d::UnitX()));

    TriMesh mesh = sphere(4, 8, 1.0);
    mesh.positions[9].x() = std::nan("");
    const SurfaceTree tree(mesh);
    EXPECT_TRUE(tree.nearest(Vector3d(2, 0, 0)));
    EXPECT_FALSE(tree.nearest(Vector3d(std::nan(""), 0, 0)));
    EXPECT_FALSE(tree.first_hit(Vector3d::Zero(), Vector3d::Zero()));
    mesh.triangles.push_back({0, 1, 9999});
    EXPECT_THROW(SurfaceTree{mesh}, std::invalid_argument);

    TriMesh same;  // thousands of equal triangles cannot be split by place
    same.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    same.triangles.assign(5000, {0, 1, 2});
    const auto hit = SurfaceTree(same).nearest(Vector3d(0.2, 0.2, 3));
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->triangle, 0U);
    EXPECT_EQ(hit->distance_mm, 3.0);
}

}  // namespace
}  // namespace stria
