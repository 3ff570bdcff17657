#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <string>

#include "firmware/core/angle.h"
#include "host/geometry/align.h"
#include "host/io/model_io.h"
#include "host/io/range_io.h"
#include "host/registration/coarse.h"
#include "host/registration/joint.h"
#include "host/registration/matches.h"
#include "tests/support/bumpy_shape.h"

namespace stria {
namespace {

using Eigen::Vector3d;

/// The ten Stanford bunny scans and their published poses, mm.
struct Bunny {
    std::vector<ScanSurface> scans;
    std::vector<ScanPose> poses;
};

std::string data_folder() {
    const char* folder = std::getenv("STRIA_TEST_DATA");
    return folder ? folder : "";
}

const Bunny& bunny() {
    static const Bunny all = [] {
        Bunny read;
        const std::string folder = data_folder() + "/stanford_bunny/";
        read.poses = read_poses(folder + "bun.conf", 1000.0);
        for (const ScanPose& pose : read.poses)
            read.scans.push_back(
                prepare_surface(read_range_image(folder + pose.file, 1000.0), {.max_edge_mm = 3}));
        return read;
    }();
    return all;
}

struct Mean {
    double deg = 0, mm = 0;
};

/// Mean distance of two sets of poses after the best common motion.
Mean distance_of(const std::vector<Rigid3>& poses) {
    std::vector<Vector3d> from, to;
    for (std::size_t i = 0; i < poses.size(); ++i)
        for (int k = -1; k < 3; ++k) {
            Vector3d p = bunny().scans[i].centre;
            if (k >= 0) p[k] += 60;  // mm: a frame of about the scan's size
            from.push_back(poses[i] * p);
            to.push_back(bunny().poses[i].world_from_scan * p);
        }
    const Rigid3 common = align_points(from, to);
    Mean mean;
    for (std::size_t i = 0; i < poses.size(); ++i) {
        const Rigid3& published = bunny().poses[i].world_from_scan;
        const Rigid3 moved = common * poses[i];
        mean.deg +=
            vector_from_rotation(moved.rotation * published.rotation.transpose()).norm() / kDegree;
        mean.mm += (moved * bunny().scans[i].centre - published * bunny().scans[i].centre).norm();
    }
    mean.deg /= static_cast<double>(poses.size());
    mean.mm /= static_cast<double>(poses.size());
    return mean;
}

TEST(Bunny, DisturbedPosesComeBackToThePublishedOnes) {
    if (data_folder().empty())
        GTEST_SKIP() << "set STRIA_TEST_DATA to the folder of real data sets";
    std::vector<Rigid3> published;
    for (const ScanPose& pose : bunny().poses) published.push_back(pose.world_from_scan);
    const double overlap_published = overlap_rms_mm(list_of(bunny().scans), published);
    for (unsigned seed = 1; seed <= 5; ++seed) {
        std::mt19937 rng(seed);
        std::vector<ScanPose> start = bunny().poses;
        for (std::size_t i = 0; i < start.size(); ++i)
            start[i].world_from_scan =
                testing::random_motion(published[i] * bunny().scans[i].centre, 3 * kDegree, 3,
                                       rng) *
                published[i];
        const JointResult result = register_jointly(bunny().scans, start);
        ASSERT_TRUE(result.converged) << seed << ": " << result.reason;
        std::vector<Rigid3> found;
        for (const JointScan& scan : result.scans) found.push_back(scan.world_from_scan);
        const Mean mean = distance_of(found);
        printf("seed %u: %.3f deg %.3f mm, overlap %.4f mm (published %.4f), %d steps\n", seed,
               mean.deg, mean.mm, result.overlap_rms_mm, overlap_published, result.iterations);
        EXPECT_LE(mean.deg, 0.17) << seed;
        EXPECT_LE(mean.mm, 0.25) << seed;
        EXPECT_LT(result.overlap_rms_mm, overlap_published);
    }
}

TEST(Bunny, ScansWithoutAnyPoseArePlacedByTheirShape) {
    if (data_folder().empty())
        GTEST_SKIP() << "set STRIA_TEST_DATA to the folder of real data sets";
    const CoarseResult coarse = place_scans(bunny().scans);
    ASSERT_TRUE(coarse.all_placed);
    std::vector<Rigid3> found;
    std::vector<ScanPose> start;
    for (const CoarseScan& scan : coarse.scans) {
        found.push_back(scan.world_from_scan);
        start.emplace_back();
        start.back().world_from_scan = scan.world_from_scan;
    }
    const Mean mean = distance_of(found);
    printf("placed by shape: %.3f deg %.3f mm\n", mean.deg, mean.mm);
    EXPECT_LE(mean.deg, 0.5);
    EXPECT_LE(mean.mm, 0.5);
    const JointResult result = register_jointly(bunny().scans, start);
    EXPECT_TRUE(result.converged) << result.reason;
    found.clear();
    for (const JointScan& scan : result.scans) found.push_back(scan.world_from_scan);
    EXPECT_LE(distance_of(found).deg, 0.17);
    EXPECT_LE(distance_of(found).mm, 0.25);
}

}  // namespace
}  // namespace stria
