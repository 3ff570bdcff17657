#include "host/mesh/compare.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stria {
namespace {

/// n x n quads over [0, size]^2 at height z.
TriMesh flat(int n, double size, double z) {
    TriMesh mesh;
    for (int y = 0; y <= n; ++y)
        for (int x = 0; x <= n; ++x) mesh.positions.push_back({size * x / n, size * y / n, z});
    const auto at = [n](int x, int y) { return static_cast<std::uint32_t>(x + (n + 1) * y); };
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            mesh.triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
            mesh.triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
        }
    return mesh;
}

TEST(CompareMeshes, OfParallelSheetsIsTheirDistance) {
    for (const std::size_t samples : {0u, 5000u}) {
        const MeshComparison result =
            compare_meshes(flat(8, 10, 0), flat(3, 10, 0.25),
                           {.samples = samples, .seed = 1, .use_a = {}, .use_b = {}});
        for (const DistanceFigures& figures : {result.a_to_b, result.b_to_a}) {
            EXPECT_DOUBLE_EQ(figures.mean_mm, 0.25);
            EXPECT_DOUBLE_EQ(figures.rms_mm, 0.25);
            EXPECT_DOUBLE_EQ(figures.max_mm, 0.25);
        }
        EXPECT_DOUBLE_EQ(result.hausdorff_mm, 0.25);
    }
}

TEST(CompareMeshes, IsNotSymmetricWhereOneReachesFarther) {
    const MeshComparison result = compare_meshes(flat(10, 10, 0), flat(10, 7, 0));
    EXPECT_NEAR(result.a_to_b.max_mm, 3 * std::sqrt(2.0), 1e-12);  // mm, rounding
    EXPECT_NEAR(result.b_to_a.max_mm, 0, 1e-12);
    EXPECT_EQ(result.hausdorff_mm, result.a_to_b.max_mm);
}

TEST(CompareMeshes, LeavesMaskedVerticesOut) {
    TriMesh a = flat(10, 10, 0);
    a.positions.back().z() = 5;
    std::vector<std::uint8_t> use(a.positions.size(), 1);
    use.back() = 0;
    for (const std::size_t samples : {0u, 2000u}) {
        CompareOptions options = {.samples = samples, .seed = 1, .use_a = use, .use_b = {}};
        EXPECT_NEAR(compare_meshes(a, flat(1, 10, 0), options).a_to_b.max_mm, 0, 1e-12);
    }
}

TEST(SampleSurface, SpreadsPointsEvenlyByArea) {
    TriMesh mesh = flat(1, 1, 0);
    const TriMesh big = flat(7, 3, 2);  // 9 times the area, many triangles
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), big.positions.begin(), big.positions.end());
    for (const auto& t : big.triangles)
        mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    const auto points = sample_surface(mesh, 20000, 3);
    Eigen::Vector3d small_mean = Eigen::Vector3d::Zero();
    double on_small = 0;
    for (const Eigen::Vector3d& p : points)
        if (p.z() < 1) {
            ++on_small;
            small_mean += p;
        }
    EXPECT_NEAR(on_small, 2000, 1);  // one a share of the area
    EXPECT_LT((small_mean / on_small - Eigen::Vector3d(0.5, 0.5, 0)).norm(),
              4 * 0.41 / std::sqrt(2000.0));  // mm: 4 sigma of a uniform square's mean
    EXPECT_EQ(sample_surface(mesh, 100, 3), sample_surface(mesh, 100, 3));
    EXPECT_NE(sample_surface(mesh, 100, 3), sample_surface(mesh, 100, 4));
}

TEST(FiguresOf, AreThoseOfTheSortedSet) {
    std::vector<double> values;
    for (int i = 100; i >= 1; --i) values.push_back(i);
    const DistanceFigures figures = figures_of(values);
    EXPECT_DOUBLE_EQ(figures.mean_mm, 50.5);
    EXPECT_DOUBLE_EQ(figures.rms_mm, std::sqrt(338350.0 / 100));
    EXPECT_DOUBLE_EQ(figures.p95_mm, 95);
    EXPECT_DOUBLE_EQ(figures.p99_mm, 99);
    EXPECT_DOUBLE_EQ(figures.max_mm, 100);
    EXPECT_EQ(figures_of({}).samples, 0u);
}

TEST(CompareMeshes, RefusesPointsAloneAndWrongMasks) {
    EXPECT_THROW(compare_meshes(TriMesh{}, flat(1, 1, 0)), std::invalid_argument);
    CompareOptions options;
    options.use_a = {1};
    EXPECT_THROW(compare_meshes(flat(1, 1, 0), flat(1, 1, 0), options), std::invalid_argument);
}

}  // namespace
}  // namespace stria
