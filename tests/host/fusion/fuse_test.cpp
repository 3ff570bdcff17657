#include "host/fusion/fuse.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "host/core/errors.h"
#include "host/geometry/parallel.h"
#include "host/mesh/mesh_info.h"
#include "tests/host/fusion/fusion_scenes.h"

namespace stria {
namespace {

struct Radial {
    double rms = 0, max = 0;
};
Radial radial_error(const TriMesh& mesh, double radius_mm) {
    Radial result;
    for (const Eigen::Vector3d& p : mesh.positions) {
        const double error = p.norm() - radius_mm;
        result.rms += error * error;
        result.max = std::max(result.max, std::abs(error));
    }
    result.rms = std::sqrt(result.rms / static_cast<double>(mesh.positions.size()));
    return result;
}

TEST(Fuse, TwelveNoiseFreeViewsGiveTheSphere) {
    const Scans scans = sphere_scans(50, 0.5);
    const FuseResult result = fuse(scans.list(), {.voxel_mm = 0.5});
    const Radial error = radial_error(result.mesh, 50);
    // Linear interpolation in triangles and cells leaves about h^2 / 8 R = 0.0006 mm each; the
    // best peer measured has 0.011 mm.
    EXPECT_LE(error.rms, 0.002);
    EXPECT_LE(error.max, 0.004);
    const MeshInfo info = mesh_info(result.mesh);
    EXPECT_TRUE(info.closed);
    EXPECT_EQ(info.components, 1u);
    EXPECT_EQ(info.euler, 2);
    EXPECT_NEAR(info.volume_mm3, 4.0 / 3 * M_PI * 125000, 2e-4 * 523599);  // outside is outside
    RecordProperty("radial_rms_mm", std::to_string(error.rms));
}

TEST(Fuse, AveragesNoiseOverViews) {
    const Scans scans = sphere_scans(50, 0.5, 0.1);
    const FuseResult result = fuse(scans.list(), {.voxel_mm = 0.5});
    // Reference simulation of the same field: 0.027 mm without smoothing.
    EXPECT_LE(radial_error(result.mesh, 50).rms, 0.030);
}

TEST(Fuse, PerspectiveViewsGiveTheSphereToo) {
    const double radius = 20, away = 120;
    Scans scans;
    for (const Eigen::Vector3d& direction : icosahedron_directions()) {
        scans.images.push_back(
            perspective_image({40, 0, 0}, 0.18, 161, [&](const Eigen::Vector3d& ray) {
                const double along = -ray.z() * away;  // to the point nearest the centre
                const double squared = radius * radius - away * away + along * along;
                return squared < 0 ? std::nan("") : along - std::sqrt(squared);
            }));
        scans.poses.push_back(looking_from(direction, away * direction));
    }
    const FuseResult result = fuse(scans.list(), {.voxel_mm = 0.4});
    EXPECT_LE(radial_error(result.mesh, radius).rms, 0.002);
    EXPECT_TRUE(mesh_info(result.mesh).closed);
}

TEST(Fuse, APlaneAtAnyAngleComesOutFlat) {
    for (const double tilt : {0.0, 0.3, 0.8, 1.1}) {
        const RangeImage image = orthographic_image(
            10, 0.5, [&](double x, double y) { return std::tan(tilt) * x + 0.1 * y; });
        const Rigid3 pose = looking_from({0.3, -0.5, 0.8}, {1, 2, 3});
        const FuseResult result = fuse({{&image, pose}}, {.voxel_mm = 0.37});
        const Eigen::Vector3d normal =
            pose.rotation * Eigen::Vector3d(-std::tan(tilt), -0.1, 1).normalized();
        ASSERT_GT(result.mesh.triangles.size(), 1000u) << tilt;
        double worst = 0;
        for (const Eigen::Vector3d& p : result.mesh.positions)
            worst = std::max(worst, std::abs(normal.dot(p - pose.translation)));
        EXPECT_LT(worst, 4e-4) << tilt;  // mm: vertices keep 1e-3 voxel off the corners
        // Nor does it leave out more than a voxel's rim of the 20 mm square.
        const double area = 400 * std::sqrt(1 + std::pow(std::tan(tilt), 2) + 0.01);
        EXPECT_GT(mesh_info(result.mesh).area_mm2, area * std::pow(1 - 0.74 / 20, 2)) << tilt;
        EXPECT_LT(mesh_info(result.mesh).area_mm2, area) << tilt;
    }
}

TEST(Fuse, TheFacesOfAThinWallStayApart) {
    // 1.5 mm thick, three voxels; each face seen straight and obliquely.
    Scans scans;
    for (const double side : {1.0, -1.0})
        for (const double lean : {0.0, 0.9}) {
            const Eigen::Vector3d up = Eigen::Vector3d(std::sin(lean), 0, side * std::cos(lean));
            const Rigid3 pose = looking_from(up);
            const Eigen::Vector3d normal = pose.rotation.transpose() * Eigen::Vector3d(0, 0, side);
            scans.images.push_back(orthographic_image(12, 0.4, [&](double x, double y) {
                return (0.75 - normal.x() * x - normal.y() * y) / normal.z();
            }));
            scans.poses.push_back(pose);
        }
    const FuseResult result = fuse(scans.list(), {.voxel_mm = 0.5});
    double worst = 0;
    std::size_t upper = 0, lower = 0;
    for (const Eigen::Vector3d& p : result.mesh.positions) {
        worst = std::max(worst, std::abs(std::abs(p.z()) - 0.75));
        ++(p.z() > 0 ? upper : lower);
    }
    EXPECT_LT(worst, 1e-4);  // mm: rounding alone, no pull from the other face
    EXPECT_GT(upper, 1500u);
    EXPECT_GT(lower, 1500u);
}

bool same(const TriMesh& a, const TriMesh& b) {
    return a.positions == b.positions && a.triangles == b.triangles &&
           std::equal(a.attributes.begin(), a.attributes.end(), b.attributes.begin(),
                      b.attributes.end(), [](const VertexAttribute& x, const VertexAttribute& y) {
                          return x.name == y.name && x.values == y.values;
                      });
}

TEST(Fuse, OrderOfScansAndNumberOfThreadsDoNotChangeABit) {
    Scans scans = sphere_scans(10, 0.5, 0.05);
    for (RangeImage& image : scans.images)
        for (RangePoint& point : image.points) point.sigma_mm = 0.05f;
    const FuseOptions options = {.voxel_mm = 0.5, .fill_holes = true};
    std::vector<FuseScan> list = scans.list();
    list.pop_back();
    list.pop_back();  // something to fill
    const TriMesh first = fuse(list, options).mesh;
    std::mt19937 rng(3);
    for (const int threads : {1, 2, 3}) {
        set_thread_count(threads);
        std::shuffle(list.begin(), list.end(), rng);
        EXPECT_TRUE(same(fuse(list, options).mesh, first)) << threads << " threads";
    }
    set_thread_count(0);
}

TEST(Fuse, SigmaOfTheMeanIsThatOfNViewsAndTheSharedPart) {
    // Four equal views of a plane: noise halves, the systematic part stays.
    RangeImage image = orthographic_image(6, 0.5, [](double, double) { return 0.0; });
    for (RangePoint& point : image.points) {
        point.sigma_mm = 0.08f;
        point.sigma_systematic_mm = 0.03f;
    }
    const FuseResult result = fuse(std::vector<FuseScan>(4, {&image, Rigid3{}}), {.voxel_mm = 0.5});
    const VertexAttribute* sigma = result.mesh.find_attribute("sigma");
    ASSERT_TRUE(sigma);
    for (const float value : sigma->values)
        EXPECT_NEAR(value, std::hypot(0.04, 0.03), 2e-4);  // mm: steps of 1.2e-4 mm
}

TEST(Fuse, FilledSurfaceIsClosedAndMarked) {
    Scans scans = sphere_scans(20, 0.5);
    std::vector<FuseScan> list = scans.list();
    list.resize(6);
    const FuseResult open = fuse(list, {.voxel_mm = 0.5});
    EXPECT_GT(mesh_info(open.mesh).boundary_edges, 0u);
    const FuseResult closed = fuse(list, {.voxel_mm = 0.5, .fill_holes = true});
    const MeshInfo info = mesh_info(closed.mesh);
    EXPECT_TRUE(info.closed);
    EXPECT_EQ(info.components, 1u);
    const std::vector<float>& filled = closed.mesh.find_attribute("filled")->values;
    std::size_t measured = 0;
    for (std::size_t v = 0; v < filled.size(); ++v) {
        const double radius = closed.mesh.positions[v].norm();
        if (filled[v] == 0) {
            ++measured;
            EXPECT_NEAR(radius, 20, 0.05);  // mm
        } else {
            EXPECT_GT(radius, 19);  // the filled part lies outside: nothing is cut off
        }
    }
    EXPECT_GT(measured, filled.size() / 2);
}

TEST(Fuse, RefusesWhatCannotBeFused) {
    const RangeImage flat = orthographic_image(5, 0.5, [](double, double) { return 0.0; });
    const FuseScan scan = {&flat, Rigid3{}};
    EXPECT_THROW(fuse({}, {}), Error);
    EXPECT_THROW(fuse({scan}, {.voxel_mm = -1}), std::invalid_argument);
    EXPECT_THROW(fuse({scan}, {.voxel_mm = 0.5, .ramp_mm = 0.7}), std::invalid_argument);
    EXPECT_THROW(fuse({scan}, {.carve = false, .fill_holes = true}), std::invalid_argument);
    EXPECT_THROW(fuse({scan}, {.voxel_mm = 1e-4, .memory_mb = 50}), Error);  // refused, not tried
    const RangeImage empty = make_range_image(4, 4);
    EXPECT_THROW(fuse({{&empty, Rigid3{}}}, {}), Error);
    Rigid3 far;
    far.translation = {1e9, 0, 0};
    EXPECT_THROW(fuse({{&flat, far}}, {.voxel_mm = 0.01}), Error);
}

TEST(Fuse, OneFarScanIsRefusedRatherThanAllocated) {
    const RangeImage flat = orthographic_image(5, 0.5, [](double, double) { return 0.0; });
    Rigid3 far;
    far.translation = {3e5, 3e5, 3e5};
    try {
        fuse({{&flat, Rigid3{}}, {&flat, far}}, {.voxel_mm = 0.5});
        FAIL() << "a box of 300 m at 0.5 mm fits no memory";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("use a larger voxel"), std::string::npos);
    }
    EXPECT_GT(fuse({{&flat, Rigid3{}}, {&flat, far}}, {.voxel_mm = 0.5, .carve = false})
                  .mesh.triangles.size(),
              0u);
}

}  // namespace
}  // namespace stria
