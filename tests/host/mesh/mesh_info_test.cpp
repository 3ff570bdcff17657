#include "host/mesh/mesh_info.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "host/io/mesh_io.h"

namespace stria {
namespace {

/// Unit cube, corner c at its bits, 12 triangles seen counter-clockwise from outside.
TriMesh cube(const Eigen::Vector3d& at = Eigen::Vector3d::Zero()) {
    TriMesh mesh;
    for (int c = 0; c < 8; ++c)
        mesh.positions.push_back(at + Eigen::Vector3d(c & 1, c >> 1 & 1, c >> 2));
    mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    return mesh;
}

TEST(MeshInfo, OfACube) {
    const MeshInfo info = mesh_info(cube({1e5, -2e5, 3e5}));
    EXPECT_EQ(info.vertices, 8u);
    EXPECT_EQ(info.triangles, 12u);
    EXPECT_EQ(info.components, 1u);
    EXPECT_EQ(info.boundary_edges, 0u);
    EXPECT_EQ(info.non_manifold_edges, 0u);
    EXPECT_EQ(info.euler, 2);
    EXPECT_NEAR(info.area_mm2, 6, 1e-9);    // mm2, rounding at 3e5 mm
    EXPECT_NEAR(info.volume_mm3, 1, 1e-9);  // mm3
    EXPECT_TRUE(info.closed);
    EXPECT_EQ(info.degenerate_triangles, 0u);
}

TEST(MeshInfo, CountsHolesFinsAndLooseParts) {
    TriMesh mesh = cube();
    mesh.triangles.pop_back();
    EXPECT_EQ(mesh_info(mesh).boundary_edges, 3u);
    EXPECT_FALSE(mesh_info(mesh).closed);
    mesh = cube();
    mesh.positions.push_back({2, 2, 2});
    mesh.triangles.push_back({0, 1, 8});  // a fin
    EXPECT_EQ(mesh_info(mesh).non_manifold_edges, 1u);
    EXPECT_EQ(mesh_info(mesh).boundary_edges, 2u);
    mesh = cube();
    mesh.positions.push_back({2, 2, 2});  // of no triangle
    EXPECT_EQ(mesh_info(mesh).euler, 2);
    EXPECT_EQ(mesh_info(mesh).referenced_vertices, 8u);
    mesh.triangles.push_back({8, 8, 1});
    EXPECT_EQ(mesh_info(mesh).degenerate_triangles, 1u);
}

TEST(MeshInfo, OfNothingIsZero) {
    const MeshInfo info = mesh_info(TriMesh{});
    EXPECT_EQ(info.components, 0u);
    EXPECT_FALSE(info.closed);
}

TEST(TriangleComponents, AreNumberedByTheirFirstTriangle) {
    TriMesh mesh = cube();
    const TriMesh other = cube({5, 0, 0});
    mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
    mesh.triangles.insert(mesh.triangles.begin(), {8, 10, 11});
    const auto component = triangle_components(mesh);
    EXPECT_EQ(component.front(), 0u);
    EXPECT_EQ(component.back(), 1u);
    EXPECT_EQ(mesh_info(mesh).components, 2u);
}

/// Counted with trimesh by the collector of the data; STL merged exactly.
struct Known {
    const char* file;
    std::size_t vertices, triangles, components, boundary, non_manifold;
    std::ptrdiff_t euler;
    double volume;
};
constexpr Known kKnown[] = {
    {"fandisk.obj", 6475, 12946, 1, 0, 0, 2, 20.2434},
    {"rocker-arm.obj", 10044, 20088, 1, 0, 0, 0, 0.0425136},
    {"homer.obj", 6002, 12000, 1, 0, 0, 2, 0.0212419},
    {"spot.obj", 2930, 5856, 1, 0, 0, 2, 0.718259},
    {"cow.obj", 2903, 5804, 1, 0, 0, 1, 53.5674},
    {"teapot.obj", 3644, 6320, 4, 1036, 0, -34, 0},  // open: its volume depends on the origin
    {"cycloidal.ply", 21384, 43368, 100, 0, 242, -58, 1.86564},
    {"featuretype.STL", 2010, 3476, 1, 576, 0, -16, 0},
};

TEST(MeshInfo, AgreesWithTheKnownFiguresOfRealMeshes) {
    const char* data = std::getenv("STRIA_TEST_DATA");
    if (!data) GTEST_SKIP() << "set STRIA_TEST_DATA to the folder of real data sets";
    for (const Known& known : kKnown) {
        const MeshInfo info = mesh_info(read_mesh(std::string(data) + "/meshes/" + known.file));
        EXPECT_EQ(info.vertices, known.vertices) << known.file;
        EXPECT_EQ(info.triangles, known.triangles) << known.file;
        EXPECT_EQ(info.components, known.components) << known.file;
        EXPECT_EQ(info.boundary_edges, known.boundary) << known.file;
        EXPECT_EQ(info.non_manifold_edges, known.non_manifold) << known.file;
        EXPECT_EQ(info.euler, known.euler) << known.file;
        if (known.volume > 0) {  // six digits are given
            EXPECT_NEAR(info.volume_mm3, known.volume, 1e-5 * known.volume) << known.file;
        }
    }
    const MeshInfo bunny =
        mesh_info(read_mesh(std::string(data) + "/stanford_bunny/bun_zipper.ply"));
    EXPECT_EQ(bunny.referenced_vertices, 34834u);
    EXPECT_EQ(bunny.boundary_edges, 223u);
    EXPECT_EQ(bunny.euler, -3);
}

}  // namespace
}  // namespace stria
