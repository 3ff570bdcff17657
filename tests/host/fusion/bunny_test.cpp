#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "host/fusion/fuse.h"
#include "host/geometry/nearest.h"
#include "host/io/model_io.h"
#include "host/io/range_io.h"
#include "host/mesh/compare.h"
#include "host/mesh/mesh_info.h"

namespace stria {
namespace {

struct Bunny {
    std::vector<RangeImage> images;
    std::vector<FuseScan> scans;
    std::vector<Eigen::Vector3d> points;  ///< all, in the world
};

Bunny read_bunny(const std::string& folder) {
    Bunny bunny;
    const auto poses = read_poses(folder + "/bun.conf", 1000);
    for (const ScanPose& pose : poses)
        bunny.images.push_back(read_range_image(folder + "/" + pose.file, 1000));
    for (std::size_t i = 0; i < poses.size(); ++i) {
        bunny.scans.push_back({&bunny.images[i], poses[i].world_from_scan});
        for (std::size_t c = 0; c < bunny.images[i].cell_count(); ++c)
            if (bunny.images[i].mask[c])
                bunny.points.push_back(poses[i].world_from_scan *
                                       bunny.images[i].points[c].position);
    }
    return bunny;
}

TEST(FuseBunny, OfTenScansIsCloseToItsPointsAndClosesWhenFilled) {
    const char* data = std::getenv("STRIA_TEST_DATA");
    if (!data) GTEST_SKIP() << "set STRIA_TEST_DATA to the folder of real data sets";
    const Bunny bunny = read_bunny(std::string(data) + "/stanford_bunny");
    const FuseOptions open = {.voxel_mm = 0.5, .max_edge_mm = 3};
    FusedVolume fused = fuse_volume(bunny.scans, open);
    const TriMesh mesh = fused_surface(fused, open);

    std::vector<Eigen::Vector3d> every_fourth;
    for (std::size_t i = 0; i < bunny.points.size(); i += 4)
        every_fourth.push_back(bunny.points[i]);
    const DistanceFigures from_points = figures_of(distances_to_surface(every_fourth, mesh));
    EXPECT_LE(from_points.rms_mm, 0.15);  // VDBFusion 0.143, plymc 0.149 on the same points

    const PointTree tree(bunny.points);
    std::vector<double> to_points;
    for (const Eigen::Vector3d& p : mesh.positions)
        to_points.push_back(tree.nearest(p, 100)->distance_mm);
    const DistanceFigures from_mesh = figures_of(to_points);
    EXPECT_LE(from_mesh.p99_mm, 0.6);
    EXPECT_LE(from_mesh.max_mm, 1.6);

    const MeshInfo info = mesh_info(mesh);
    EXPECT_LE(info.boundary_edges, 1500u);
    EXPECT_EQ(info.non_manifold_edges, 0u);
    RecordProperty("boundary_edges", static_cast<int>(info.boundary_edges));
    RecordProperty("point_rms_mm", std::to_string(from_points.rms_mm));

    FuseOptions filled = open;
    filled.fill_holes = true;
    const MeshInfo closed = mesh_info(fused_surface(fused, filled));
    EXPECT_EQ(closed.boundary_edges, 0u);
    EXPECT_EQ(closed.non_manifold_edges, 0u);
}

}  // namespace
}  // namespace stria
