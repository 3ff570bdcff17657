#include <gtest/gtest.h>

#include <cstdlib>
#include <numbers>

#include "host/core/errors.h"
#include "host/io/model_io.h"
#include "host/io/whole_file.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

ScanPose pose_of(const std::string& file, double angle) {
    ScanPose pose;
    pose.file = file;
    pose.world_from_scan = {rotation_from_vector({angle, 0.2, -0.3}), {1.0 / 3, -2, 1e-7}};
    return pose;
}

TEST(PosesIo, RoundTripIsExact) {
    std::vector<ScanPose> poses = {pose_of("a.ply", 0.1), pose_of("b \"2\".ply", 1.7)};
    for (int i = 0; i < 36; ++i) poses[1].covariance(i / 6, i % 6) = 1.0 / (i + 1);
    poses[0].fixed = true;
    const auto back = parse_poses(format_poses(poses), "poses.toml");
    ASSERT_EQ(back.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(back[i].file, poses[i].file);
        EXPECT_EQ(back[i].world_from_scan.rotation, poses[i].world_from_scan.rotation);
        EXPECT_EQ(back[i].world_from_scan.translation, poses[i].world_from_scan.translation);
        EXPECT_EQ(back[i].covariance, poses[i].covariance);
        EXPECT_EQ(back[i].fixed, poses[i].fixed);
    }
}

TEST(PosesIo, ConjugatesStanfordsQuaternion) {
    // Quarter turn about z: R(q) sends x to y, its conjugate sends x to -y.
    const double h = std::numbers::sqrt2 / 2;
    const auto poses = parse_poses("camera 0 0 0 0 0 0 1\nbmesh s.ply 1 2 3 0 0 " +
                                       std::to_string(h) + " " + std::to_string(h) + "\r\n",
                                   "x.conf", 1000);
    ASSERT_EQ(poses.size(), 1U);
    EXPECT_EQ(poses[0].file, "s.ply");
    const Eigen::Vector3d moved = poses[0].world_from_scan * Eigen::Vector3d(1, 0, 0);
    EXPECT_LT((moved - Eigen::Vector3d(1000, 1999, 3000)).norm(), 1e-9);  // mm, rounding
}

TEST(PosesIo, ReadsATextMatrixOfFewDigits) {
    const auto poses =
        parse_poses("0.866 -0.5 0 1\n0.5, 0.866, 0, 2\n0 0 1 3\n\n0 0 0 1", "t.txt", 10);
    ASSERT_EQ(poses.size(), 1U);
    EXPECT_TRUE(is_rigid(poses[0].world_from_scan, 1e-12));
    EXPECT_EQ(poses[0].world_from_scan.translation, Eigen::Vector3d(10, 20, 30));
}

TEST(PosesIo, RefusesWhatIsNoMotion) {
    const auto message = [](const std::string& text, const std::string& name) {
        return message_of([&] { parse_poses(text, name); });
    };
    EXPECT_NE(message("2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1", "t.txt").find("no rotation"),
              std::string::npos);
    EXPECT_NE(message("1 0 0 0", "t.txt").find("16 numbers"), std::string::npos);
    EXPECT_NE(message("1 0 0 x", "t.txt").find("line 1: expected a finite number, found 'x'"),
              std::string::npos);
    EXPECT_NE(message("1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1", "t.txt").find("last row"),
              std::string::npos);
    EXPECT_NE(message("bmesh a 0 0 0 0 0 1", "t.conf").find("line 1: "), std::string::npos);
    EXPECT_NE(message("bmesh a 0 0 0 0 0 2 2", "t.conf").find("length 1"), std::string::npos);
    EXPECT_NE(message("", "t.toml").find("found none"), std::string::npos);
    EXPECT_NE(message("[[scan]]\nfile = 'a'\nworld_from_scan = [1]\n", "t.toml").find("line 3"),
              std::string::npos);
}

TEST(FindPose, MatchesByPathThenTailThenStem) {
    const std::vector<ScanPose> poses = {
        pose_of("scans/0001/range.ply", 0), pose_of("scans/0002/range.ply", 0),
        pose_of("bun000.ply", 0), pose_of("data/bun045.ply", 0), pose_of("other/bun045.ply", 0)};
    const auto file = [&](const std::string& path) { return find_pose(poses, path).file; };
    EXPECT_EQ(file("/part/scans/0002/range.ply"), "scans/0002/range.ply");
    EXPECT_EQ(file("part/scans/0002"), "scans/0002/range.ply");
    EXPECT_EQ(file("part/scans/0002/"), "scans/0002/range.ply");
    EXPECT_EQ(file("part/scans/0001/recording.stria"), "scans/0001/range.ply");
    EXPECT_EQ(file("elsewhere/bun000.stria"), "bun000.ply");
    EXPECT_EQ(file("x/other/bun045.ply"), "other/bun045.ply");
    EXPECT_EQ(file("data/bun045.ply"), "data/bun045.ply");
    EXPECT_THROW(file("bun090.ply"), Error);
    EXPECT_NE(message_of([&] { file("third/bun045.ply"); }).find("two poses fit"),
              std::string::npos);
}

TEST(FindPose, LooksPastLeadingParents) {
    const std::vector<ScanPose> poses = {pose_of("../a/bun.ply", 0), pose_of("../b/bun.ply", 0)};
    EXPECT_EQ(find_pose(poses, "/data/b/bun.ply").file, "../b/bun.ply");
    EXPECT_EQ(find_pose(poses, "../../a/bun.ply").file, "../a/bun.ply");
}

TEST(PosesIo, ReadsTheBunnysPosesAndTheCarsMatrix) {
    const char* data = std::getenv("STRIA_TEST_DATA");
    if (!data) GTEST_SKIP() << "set STRIA_TEST_DATA to the folder of real data sets";
    const auto poses = read_poses(std::string(data) + "/stanford_bunny/bun.conf", 1000);
    ASSERT_EQ(poses.size(), 10U);
    EXPECT_NEAR(find_pose(poses, "x/bun045.ply").world_from_scan.translation.x(), -52.0211,
                1e-12);  // mm, rounding
    for (const ScanPose& pose : poses) EXPECT_TRUE(is_rigid(pose.world_from_scan, 1e-12));
    const auto car =
        read_poses(std::string(data) + "/icp_car_clouds/reference_transform.txt", 1000);
    ASSERT_EQ(car.size(), 1U);
    EXPECT_NEAR(car[0].world_from_scan.translation.y(), -216.127872467041, 1e-9);
}

}  // namespace
}  // namespace stria
