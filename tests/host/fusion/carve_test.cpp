#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "firmware/core/pulse.h"
#include "host/core/errors.h"
#include "host/fusion/fuse.h"
#include "host/geometry/nearest.h"
#include "host/geometry/range_grid.h"
#include "host/mesh/compare.h"
#include "host/mesh/mesh_info.h"
#include "tests/host/fusion/fusion_scenes.h"

namespace stria {
namespace {

using Eigen::Vector3d;

constexpr double kVoxel = 0.4;
constexpr double kRamp = 2 * kVoxel;

void add_box(TriMesh& mesh, const Vector3d& low, const Vector3d& high) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (int c = 0; c < 8; ++c)
        mesh.positions.push_back(
            {c & 1 ? high.x() : low.x(), c & 2 ? high.y() : low.y(), c & 4 ? high.z() : low.z()});
    const std::array<std::uint32_t, 3> faces[12] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                                    {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                                    {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    for (const auto& t : faces)
        mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

/// A block with a thin wall (1.5 mm) on top of it.
TriMesh block_with_wall() {
    TriMesh mesh;
    add_box(mesh, {-15, -10, -6}, {15, 10, 0});
    add_box(mesh, {-10, -0.75, -1}, {10, 0.75, 12});
    return mesh;
}

/// No light comes back from here: a dark patch on top of the block and a mirror on the wall.
bool swallows_light(const Vector3d& p) {
    const bool dark = std::abs(p.z()) < 1e-6 && p.x() > 4 && p.x() < 12 && p.y() > 3 && p.y() < 9;
    const bool mirror = std::abs(std::abs(p.y()) - 0.75) < 1e-6 && p.x() > -6 && p.x() < 2 &&
                        p.z() > 3 && p.z() < 9;
    return dark || mirror;
}

/// Sees the mesh from a camera, if the laser reaches the same place.
RangeImage cast(const SurfaceTree& tree, const Rigid3& pose, const Vector3d& laser_in_scan) {
    const Vector3d laser = pose * laser_in_scan;
    return perspective_image(laser_in_scan, 0.16, 221, [&](const Vector3d& ray) {
        const Vector3d direction = pose.rotation * ray;
        const auto hit = tree.first_hit(pose.translation, direction, 1, 1000);
        if (!hit) return std::nan("");
        const Vector3d point = pose.translation + hit->t * direction;
        if (swallows_light(point)) return std::nan("");
        if (tree.first_hit(laser, point - laser, 0, 1 - 1e-6)) return std::nan("");  // shadow
        return hit->t;
    });
}

Scans scan_block() {
    const SurfaceTree tree(block_with_wall());
    Scans scans;
    std::vector<Vector3d> views = {{0, 0.2, 1}};
    for (int k = 0; k < 8; ++k)
        for (const double height : {0.15, 0.9})
            views.push_back({std::cos(k * M_PI / 4), std::sin(k * M_PI / 4), height});
    for (const Vector3d& view : views) {
        const Rigid3 pose = looking_from(view.normalized(), 150 * view.normalized());
        scans.poses.push_back(pose);
        scans.images.push_back(cast(tree, pose, {45, 0, 0}));
    }
    return scans;
}

/// Whether light comes back from here to that scan's camera.
bool is_measured(const SurfaceTree& tree, const Vector3d& point, const Vector3d& camera,
                 const Vector3d& laser, const Vector3d& looks_along) {
    const auto blocked = [&](const Vector3d& eye) {
        return tree.first_hit(eye, point - eye, 0, 1 - 1e-6).has_value();
    };
    const Vector3d ray = point - camera;
    const bool in_image = ray.dot(looks_along) > 0.999 * std::cos(0.16) * ray.norm();
    return in_image && !swallows_light(point) && !blocked(camera) && !blocked(laser);
}

/// Whether a place lies on the segment from camera or laser to a measured point, at least
/// `before_mm` in front of it: what a scan sees to be free, by ray casting alone.
bool is_seen_free(const SurfaceTree& tree, const Vector3d& at, const Vector3d& camera,
                  const Vector3d& laser, const Vector3d& looks_along, double before_mm) {
    for (const Vector3d& eye : {camera, laser}) {
        const Vector3d direction = (at - eye).normalized();
        const auto hit = tree.first_hit(eye, direction, 0, 1000);
        if (hit && hit->t > (at - eye).norm() + before_mm &&
            is_measured(tree, eye + hit->t * direction, camera, laser, looks_along))
            return true;
    }
    return false;
}

/// Share of the space that any scan sees to be free which the volume calls empty or near a surface.
double share_known_free(const FusedVolume& fused, const SurfaceTree& tree, const Scans& scans) {
    std::mt19937 rng(9);
    std::uniform_real_distribution<double> uniform;
    const CarvedBox& box = fused.volume.carved();
    const Vector3d low = box.min.cast<double>() * (8 * kVoxel);
    const Vector3d size =  // to the last voxel's centre
        box.size.cast<double>() * (8 * kVoxel) - Vector3d::Constant(kVoxel);
    std::size_t known = 0, free = 0;
    for (int k = 0; k < 20000; ++k) {
        const Vector3d at =
            low + size.cwiseProduct(Vector3d(uniform(rng), uniform(rng), uniform(rng)));
        bool seen = false;
        for (std::size_t i = 0; i < scans.images.size() && !seen; ++i) {
            const Rigid3& pose = scans.poses[i];
            for (const Station& station : scans.images[i].stations)
                seen = seen ||
                       is_seen_free(tree, at, pose * station.camera_in_scan,
                                    pose * station.laser_in_scan, -pose.rotation.col(2), kRamp);
        }
        free += seen;
        known += seen && fused.volume.state_at(at) != VoxelState::unseen;
    }
    EXPECT_GT(free, 3000u);
    return static_cast<double>(known) / static_cast<double>(free);
}

TEST(Carve, TakesNoTrueSurfaceOfWallDarkPatchOrMirrorAndFindsTheSeenEmptySpace) {
    const Scans scans = scan_block();
    const FuseOptions options = {.voxel_mm = kVoxel, .fill_holes = true};
    FusedVolume fused = fuse_volume(scans.list(), options);

    // One voxel below the true surface, patches and all, nothing may be empty.
    const TriMesh truth = block_with_wall();
    const SurfaceTree tree(truth);
    std::size_t carved = 0, dark = 0;
    for (const Vector3d& p : sample_surface(truth, 200000, 4)) {
        const auto hit = tree.nearest(p);
        const auto& t = truth.triangles[hit->triangle];
        const Vector3d normal = (truth.positions[t[1]] - truth.positions[t[0]])
                                    .cross(truth.positions[t[2]] - truth.positions[t[0]])
                                    .normalized();
        carved += fused.volume.state_at(p - kVoxel * normal) == VoxelState::empty;
        dark += swallows_light(p);
    }
    EXPECT_EQ(carved, 0u);
    EXPECT_GT(dark, 3000u);

    const double share = share_known_free(fused, tree, scans);
    EXPECT_GE(share, 0.99);
    RecordProperty("share_known_free", std::to_string(share));

    const TriMesh mesh = fused_surface(fused, options);
    EXPECT_TRUE(mesh_info(mesh).closed);
    // The patches are bridged in place: camera and laser rays graze over them.
    std::vector<Vector3d> places = sample_surface(truth, 20000, 5);
    std::erase_if(places, [](const Vector3d& p) { return p.z() < -5.9; });  // no view of the bottom
    EXPECT_LT(figures_of(distances_to_surface(places, mesh)).p95_mm, kVoxel);
}

TEST(Carve, WorksForARailWhoseCameraAndLaserMove) {
    const SurfaceTree tree(block_with_wall());
    Scans scans;
    scans.poses = {Rigid3{}};
    RangeImage image = make_range_image(161, 161);  // x: s, y: angle in the sheet
    image.kind = MachineKind::rail;
    for (int i = 0; i < 161; ++i) {
        const double s = -20 + 0.25 * i;
        const Vector3d laser(s, 0, 150), camera(s - 60, 10, 150);
        image.stations.push_back({.s = s, .camera_in_scan = camera, .laser_in_scan = laser});
        for (int j = 0; j < 161; ++j) {
            const Vector3d ray = Vector3d(0, 0.16 * (j / 80.0 - 1), -1).normalized();
            const auto hit = tree.first_hit(laser, ray, 1, 1000);
            if (!hit) continue;
            const Vector3d point = laser + hit->t * ray;
            if (swallows_light(point) || tree.first_hit(camera, point - camera, 0, 1 - 1e-6))
                continue;
            image.mask[image.cell(i, j)] = 1;
            image.points[image.cell(i, j)].position = point;
            image.points[image.cell(i, j)].s = s;
        }
    }
    scans.images = {image};
    FusedVolume fused = fuse_volume(scans.list(), {.voxel_mm = kVoxel});
    const CarvedBox& box = fused.volume.carved();
    std::mt19937 rng(2);
    const auto border = border_distance(image, range_triangles(image));
    std::size_t known = 0, all = 0;
    for (std::size_t c = 0; c < image.cell_count(); ++c) {
        if (border[c] < 2) continue;  // the seen space ends there
        const RangePoint& point = image.points[c];
        const Station station = station_at(image, point.s);
        for (const Vector3d& eye : {station.camera_in_scan, station.laser_in_scan}) {
            const double before = 2 + 10 * static_cast<double>(rng() % 1000) / 1000;
            const Vector3d at = point.position + before * (eye - point.position).normalized();
            if (!box.contains(
                    (at / kVoxel).array().round().cast<int>().matrix().unaryExpr([](int v) {
                        return v >> 3;
                    })))
                continue;
            ++all;
            known += fused.volume.state_at(at) != VoxelState::unseen;
        }
    }
    EXPECT_GT(all, 3000u);
    EXPECT_GE(static_cast<double>(known), 0.99 * static_cast<double>(all));
    // Under the block nothing was seen.
    EXPECT_EQ(fused.volume.state_at({0, 5, -3}), VoxelState::unseen);
    EXPECT_THROW(
        fuse_volume(scans.list(), {.voxel_mm = kVoxel, .carve = true, .carve_background = true}),
        Error);
}

TEST(Carve, DoubtfulPulsesAndCellsWithTwoReturnsDoNotCarve) {
    for (const std::uint16_t flag :
         {std::uint16_t{0}, std::uint16_t{kPulseSpatialFallback}, std::uint16_t{kPulseOverlapping},
          std::uint16_t{kPulseGhostSuspected}}) {
        RangeImage image =
            orthographic_image(10, 0.4, [](double x, double) { return x < 0 ? 0.0 : 8.0; });
        for (RangePoint& point : image.points) point.flags = flag;
        const FusedVolume fused = fuse_volume({{&image, Rigid3{}}}, {.voxel_mm = kVoxel});
        const VoxelState expected = flag == 0 ? VoxelState::empty : VoxelState::unseen;
        EXPECT_EQ(fused.volume.state_at({-5, 0, 6}), expected) << flag;
        EXPECT_EQ(fused.volume.state_at({-5, 0, 0}), VoxelState::near_surface) << flag;
        EXPECT_EQ(fused.volume.state_at({-5, 0, -2}), VoxelState::unseen) << flag;
    }
    RangeImage image =
        orthographic_image(10, 0.4, [](double x, double) { return x < 0 ? 0.0 : 8.0; });
    for (std::uint32_t c = 0; c < image.cell_count(); ++c) {
        FurtherReturn other;
        other.cell = c;
        image.further.push_back(other);
    }
    const FusedVolume fused = fuse_volume({{&image, Rigid3{}}}, {.voxel_mm = kVoxel});
    EXPECT_EQ(fused.volume.state_at({-5, 0, 6}), VoxelState::unseen);
}

TEST(Carve, EndsThreeSigmaAndTheRampInFront) {
    for (const float sigma : {0.0f, 0.5f}) {
        RangeImage image =
            orthographic_image(10, 0.4, [](double x, double) { return x < 0 ? 0.0 : 12.0; });
        for (RangePoint& point : image.points) point.sigma_mm = sigma;
        const FusedVolume fused =
            fuse_volume({{&image, Rigid3{}}}, {.voxel_mm = kVoxel, .ramp_mm = 1.0});
        // No gap of the unseen anywhere between the surface and the empty space.
        for (double z = 0; z < 10; z += kVoxel)
            EXPECT_NE(fused.volume.state_at({-5, 0, z}), VoxelState::unseen) << z;
        const double end = 3 * static_cast<double>(sigma) + 1.0;
        EXPECT_EQ(fused.volume.state_at({-5, 0, end - kVoxel}), VoxelState::near_surface);
        EXPECT_EQ(fused.volume.state_at({-5, 0, end + 3 * kVoxel}), VoxelState::empty);
    }
}

TEST(Carve, TakesTheBackgroundOnlyWhenAsked) {
    // A small tile before nothing; a second scan stretches the volume.
    const RangeImage tile = orthographic_image(12, 0.4, [](double x, double y) {
        return std::abs(x) < 3 && std::abs(y) < 3 ? 4.0 : std::nan("");
    });
    const RangeImage wide = orthographic_image(12, 0.4, [](double, double) { return -6.0; });
    const std::vector<FuseScan> scans = {{&tile, Rigid3{}},
                                         {&wide, looking_from({0, 0, -1}, {0, 0, -12})}};
    const Vector3d beside(9, 0, 3), behind(0, 0, 1);
    const FusedVolume kept = fuse_volume(scans, {.voxel_mm = kVoxel});
    EXPECT_EQ(kept.volume.state_at(beside), VoxelState::unseen);
    const FusedVolume taken = fuse_volume(scans, {.voxel_mm = kVoxel, .carve_background = true});
    EXPECT_EQ(taken.volume.state_at(beside), VoxelState::empty);
    EXPECT_EQ(taken.volume.state_at(behind), VoxelState::unseen);
    EXPECT_EQ(taken.volume.state_at({0, 0, 4}), VoxelState::near_surface);
}

TEST(Carve, OfPerspectiveBackgroundFollowsTheCells) {
    const double away = 100;
    const RangeImage ball = perspective_image({30, 0, 0}, 0.25, 161, [&](const Vector3d& ray) {
        const double along = -ray.z() * away, squared = 100 - away * away + along * along;
        return squared < 0 ? std::nan("") : along - std::sqrt(squared);
    });
    const Rigid3 pose = looking_from({0, 0, 1}, {0, 0, away});
    const RangeImage wall = orthographic_image(14, 0.4, [](double, double) { return 14.0; });
    const std::vector<FuseScan> scans = {{&ball, pose}, {&wall, looking_from({0, 0, -1})}};
    const FusedVolume taken = fuse_volume(scans, {.voxel_mm = kVoxel, .carve_background = true});
    for (int k = 0; k < 12; ++k) {
        const Vector3d round(std::cos(k * M_PI / 6), std::sin(k * M_PI / 6), 0);
        EXPECT_EQ(taken.volume.state_at(11.5 * round), VoxelState::empty) << k;
        EXPECT_EQ(taken.volume.state_at(8.0 * round - Vector3d(0, 0, 4)), VoxelState::unseen) << k;
    }
}

}  // namespace
}  // namespace stria
