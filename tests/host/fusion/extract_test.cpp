#include "host/fusion/extract.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "host/fusion/cube_cases.h"
#include "host/mesh/mesh_info.h"

namespace stria {
namespace {

/// Sets every voxel of a cube of bricks by distance(x, y, z) in voxels; not a number: unseen.
template <typename Distance>
SdfVolume volume_of(int bricks, Distance distance) {
    SdfVolume volume(1.0);
    for (int z = 0; z < bricks; ++z)
        for (int y = 0; y < bricks; ++y)
            for (int x = 0; x < bricks; ++x) {
                Brick& brick = volume.brick(volume.find_or_add({x, y, z}));
                brick.sums = std::make_unique<DistanceSums>();
                for (int i = 0; i < kBrickVoxels; ++i) {
                    const double d =
                        distance(8 * x + (i & 7), 8 * y + (i >> 3 & 7), 8 * z + (i >> 6));
                    if (std::isnan(d)) continue;
                    const auto at = static_cast<std::size_t>(i);
                    brick.sums->weight[at] = 1;
                    brick.sums->weighted_distance[at] = std::llrint(d * kDistanceSteps);
                }
            }
    return volume;
}

TriMesh surface_of(const SdfVolume& volume) {
    return extract_surface(volume, ClosingBody{}, {.min_component_voxels2 = 0});
}

TEST(CubeCases, HaveOppositeSurfacesOfTheSameEdges) {
    for (unsigned inside = 0; inside < 256; ++inside) {
        const CubeCases& cases = cube_cases();
        std::array<int, 12> used{};
        for (const auto& t : cases.triangles[inside])
            for (const std::uint8_t e : t) used[e] = 1;
        for (std::size_t e = 0; e < 12; ++e) {
            const unsigned low = cases.edges[e].low, high = low | 1u << cases.edges[e].axis;
            EXPECT_EQ(used[e], int((inside >> low ^ inside >> high) & 1)) << inside;
        }
    }
}

TEST(ExtractSurface, OfRandomNoiseHasNoCrackAndNoNonManifoldEdge) {
    std::mt19937 rng(17);
    std::uniform_real_distribution<double> noise(-1, 1);
    for (int trial = 0; trial < 4; ++trial) {
        const SdfVolume volume = volume_of(4, [&](int x, int y, int z) {
            const bool rim = std::min({x, y, z}) == 0 || std::max({x, y, z}) == 31;
            return rim ? 1.0 : noise(rng);  // outside all round, so that it closes
        });
        const MeshInfo info = mesh_info(surface_of(volume));
        EXPECT_GT(info.triangles, 50000u);
        EXPECT_EQ(info.boundary_edges, 0u);
        EXPECT_EQ(info.non_manifold_edges, 0u);
        EXPECT_EQ(info.degenerate_triangles, 0u);
    }
}

TEST(ExtractSurface, OfValuesOnTheSurfaceItselfStaysManifold) {
    std::mt19937 rng(23);
    const SdfVolume volume = volume_of(3, [&](int x, int y, int z) {
        const bool rim = std::min({x, y, z}) == 0 || std::max({x, y, z}) == 23;
        return rim ? 1.0 : static_cast<double>(rng() % 3) - 1;  // -1, 0, 1
    });
    const MeshInfo info = mesh_info(surface_of(volume));
    EXPECT_EQ(info.boundary_edges, 0u);
    EXPECT_EQ(info.non_manifold_edges, 0u);
    EXPECT_EQ(info.degenerate_triangles, 0u);
}

TEST(ExtractSurface, OfNoiseWithUnseenPartsHasNoNonManifoldEdge) {
    std::mt19937 rng(29);
    std::uniform_real_distribution<double> noise(-1, 1);
    const SdfVolume volume =
        volume_of(3, [&](int, int, int) { return rng() % 10 == 0 ? std::nan("") : noise(rng); });
    const MeshInfo info = mesh_info(surface_of(volume));
    EXPECT_GT(info.triangles, 1000u);
    EXPECT_GT(info.boundary_edges, 0u);
    EXPECT_EQ(info.non_manifold_edges, 0u);
}

TEST(ExtractSurface, CutsALinearFieldExactly) {
    const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();
    const SdfVolume volume = volume_of(3, [&](int x, int y, int z) {
        return normal.dot(Eigen::Vector3d(x - 11.3, y - 12.1, z - 11.7));
    });
    const TriMesh mesh = surface_of(volume);
    ASSERT_GT(mesh.triangles.size(), 500u);
    const std::vector<float>& normals = mesh.find_attribute("normal")->values;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        EXPECT_NEAR(normal.dot(mesh.positions[v] - Eigen::Vector3d(11.3, 12.1, 11.7)), 0,
                    1e-3);  // voxels: vertices keep 1e-3 off the corners
        // At the rim a vertex may have nothing but one sliver of a triangle.
        if (mesh.positions[v].minCoeff() < 1 || mesh.positions[v].maxCoeff() > 22) continue;
        const Eigen::Vector3d own(normals[3 * v], normals[3 * v + 1], normals[3 * v + 2]);
        EXPECT_GT(own.dot(normal), 0.99);
    }
}

TEST(ExtractSurface, EndsWhereNothingIsKnown) {
    const SdfVolume volume =
        volume_of(2, [](int x, int, int z) { return x < 10 ? z - 7.5 : std::nan(""); });
    for (const Eigen::Vector3d& p : surface_of(volume).positions) {
        EXPECT_LE(p.x(), 9.0);
        EXPECT_NEAR(p.z(), 7.5, 1e-4);
    }
}

TEST(ExtractSurface, DropsComponentsBelowTheAskedSize) {
    const auto ball = [](int x, int y, int z, double cx, double r) {
        return std::sqrt((x - cx) * (x - cx) + (y - 12) * (y - 12) + (z - 12) * (z - 12)) - r;
    };
    const SdfVolume volume = volume_of(4, [&](int x, int y, int z) {
        return std::min(ball(x, y, z, 8, 5), ball(x, y, z, 22, 2));
    });
    EXPECT_EQ(mesh_info(surface_of(volume)).components, 2u);
    const TriMesh kept = extract_surface(volume, ClosingBody{}, {.min_component_voxels2 = 100});
    const MeshInfo info = mesh_info(kept);
    EXPECT_EQ(info.components, 1u);
    EXPECT_EQ(info.vertices, info.referenced_vertices);
    for (const Eigen::Vector3d& p : kept.positions) EXPECT_LT(p.x(), 14);
}

}  // namespace
}  // namespace stria
