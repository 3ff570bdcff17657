#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "host/cli/artefact_toml.h"
#include "host/io/mesh_io.h"
#include "host/io/range_io.h"
#include "host/io/whole_file.h"
#include "tests/host/cli/run_stria.h"
#include "tests/host/io/temporary_folder.h"
#include "tests/host/verify/synthetic_range.h"

namespace stria {
namespace {

using Eigen::Vector3d;
using test_support::Ended;
using test_support::has;
using test_support::number_of;
using test_support::SyntheticRange;

Ended verify(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "verify");
    return test_support::run_stria(arguments);
}

const std::string kSphere =
    "kind = \"sphere\"\nname = \"S30\"\ndiameter_mm = 30\ndiameter_u_mm = 0.001\n";

/// A sphere before a wall.
void write_sphere_scan(const std::string& path, unsigned seed, const Vector3d& centre) {
    SyntheticRange scene;
    scene.balls = {{centre, 15}};
    scene.tiles = {{{0, 0, -430}, {260, 0, 0}, {0, 200, 0}}};
    write_range_image(path, make_range(scene, seed));
}

TEST(VerifySphere, TellsFormAndSizeOfEveryPosition) {
    const TemporaryFolder folder;
    write_sphere_scan(folder / "a.ply", 1, {0, 0, -400});
    write_sphere_scan(folder / "b.ply", 2, {50, 30, -390});
    write_whole_file(folder / "artefact.toml", kSphere);
    const Ended ended = verify({"sphere", folder / "a.ply", folder / "b.ply", "--artefact",
                                folder / "artefact.toml", "--out", folder / "page.html", "--json"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_LT(std::abs(number_of(ended.out, "size_mm")), 0.01);
    // Noise of 10 um along the ray is 10 to 5 um along the normal: six times their rms, more or
    // less.
    EXPECT_GT(number_of(ended.out, "form_mm"), 0.03);
    EXPECT_LT(number_of(ended.out, "form_mm"), 0.07);
    EXPECT_NEAR(number_of(ended.out, "sigma_ratio"), 1, 0.1);
    EXPECT_GT(number_of(ended.out, "points_used"), 1000);
    EXPECT_TRUE(has(ended.out, "following the procedure of"));
    EXPECT_TRUE(has(ended.out, "these are 2")) << "fewer positions than asked for";
    const std::string page = read_whole_file(folder / "page.html");
    EXPECT_TRUE(has(page, "no claim of conformity"));
    EXPECT_TRUE(has(page, "data:image/png;base64"));
    EXPECT_FALSE(has(page, "src='http") || has(page, "href='http") || has(page, "url("));
    EXPECT_EQ(verify({"sphere", folder / "a.ply", "--artefact", folder / "artefact.toml", "--out",
                      folder / "page.html"})
                  .code,
              1)
        << "the page exists";
}

TEST(VerifySphere, JudgesByTheLimitLessTheUncertainty) {
    const TemporaryFolder folder;
    write_sphere_scan(folder / "a.ply", 1, {0, 0, -400});
    write_whole_file(folder / "wide.toml", kSphere + "[mpe]\nform_mm = 0.1\nsize_mm = 0.02\n");
    write_whole_file(folder / "narrow.toml", kSphere + "[mpe]\nform_mm = 0.02\n");
    const Ended wide = verify({"sphere", folder / "a.ply", "--artefact", folder / "wide.toml"});
    EXPECT_EQ(wide.code, 0) << wide.err;
    EXPECT_TRUE(has(wide.out, "accepted"));
    const Ended narrow =
        verify({"sphere", folder / "a.ply", "--artefact", folder / "narrow.toml", "--json"});
    EXPECT_EQ(narrow.code, 1);
    EXPECT_TRUE(has(narrow.out, "\"verdict\": \"rejected\""));
}

TEST(VerifySphere, SaysWhatACloudDoesNotState) {
    const TemporaryFolder folder;
    SyntheticRange scene;
    scene.balls = {{{0, 0, -400}, 15}};
    const RangeImage image = make_range(scene, 1);
    PointCloud cloud;
    for (std::size_t i = 0; i < image.cell_count(); ++i)
        if (image.mask[i] != 0) cloud.positions.push_back(image.points[i].position);
    write_points(folder / "cloud.ply", cloud);
    write_whole_file(folder / "artefact.toml", kSphere);
    const Ended ended =
        verify({"sphere", folder / "cloud.ply", "--artefact", folder / "artefact.toml", "--json"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_TRUE(has(ended.out, "\"predicted_sigma_mm\": null"));
    EXPECT_TRUE(has(ended.out, "where the camera stood"));
    EXPECT_TRUE(has(ended.out, "no standard deviation"));
    EXPECT_TRUE(has(ended.out, "states no temperature"));
}

TEST(VerifySphere, RefusesWhatDoesNotFit) {
    const TemporaryFolder folder;
    write_sphere_scan(folder / "a.ply", 1, {0, 0, -400});
    const auto fails = [&](const std::string& artefact, const std::string& part,
                           const std::vector<std::string>& more = {}) {
        write_whole_file(folder / "artefact.toml", artefact);
        std::vector<std::string> arguments = {"sphere", folder / "a.ply", "--artefact",
                                              folder / "artefact.toml"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Ended ended = verify(arguments);
        EXPECT_EQ(ended.code, 1) << artefact;
        EXPECT_TRUE(has(ended.err, part)) << ended.err;
    };
    fails("kind = \"sphere\"\ndiameter_mm = 33\ndiameter_u_mm = 0.001\n", "a.ply: found a sphere");
    fails("kind = \"plane\"\n", "expected \"sphere\"");
    fails("kind = \"sphere\"\ndiameter_mm = 30\n", "diameter_u_mm");
    fails(kSphere + "diametre_mm = 3\n", "diametre_mm");
    fails(kSphere +
              "[temperature]\nmeasured_c = 20\nmeasured_u_c = 1\ncte_per_k = 11.5\n"
              "cte_u_per_k = 0\n",
          "is it in 1e-6?");
    fails(kSphere, "20 to 85 deg", {"--incidence", "90"});
    EXPECT_EQ(verify({"sphere", folder / "a.ply"}).code, 2);
}

/// A bar of two spheres before a wall.
void write_bar_scan(const std::string& path, unsigned seed, const Vector3d& way) {
    SyntheticRange scene;
    const Vector3d middle(0, 0, -410), half = 50 * way.normalized();
    scene.balls = {{middle - half, 15}, {middle + half, 15}};
    scene.tiles = {{{0, 0, -470}, {400, 0, 0}, {0, 300, 0}}};
    write_range_image(path, make_range(scene, seed));
}

const std::string kBar =
    "diameters_mm = [30, 30]\ndiameters_u_mm = [0.001, 0.001]\nlengths_mm = [100]\n"
    "lengths_u_mm = [0.002]\n";

TEST(VerifyBar, TellsSpacingAndLength) {
    const TemporaryFolder folder;
    write_bar_scan(folder / "a.ply", 1, {1, 0.2, 0});
    write_bar_scan(folder / "b.ply", 2, {0.6, 0.5, 0.6});
    write_whole_file(folder / "bar.toml", "kind = \"bar\"\n" + kBar +
                                              "[mpe]\nspacing_mm = 0.02\nlength_mm = 0.03\n"
                                              "length_per_mm = 1e-5\n");
    const Ended spacing = verify({"bar", folder / "a.ply", folder / "b.ply", "--artefact",
                                  folder / "bar.toml", "--out", folder / "bar.html", "--json"});
    ASSERT_EQ(spacing.code, 0) << spacing.err;
    EXPECT_LT(std::abs(number_of(spacing.out, "spacing_mm")), 0.01);
    EXPECT_TRUE(has(spacing.out, "\"verdict\": \"accepted\""));
    EXPECT_TRUE(has(read_whole_file(folder / "bar.html"), "sphere 2"));
    const Ended length = verify({"length", folder / "a.ply", folder / "b.ply", "--artefact",
                                 folder / "bar.toml", "--out", folder / "length.html", "--json"});
    ASSERT_EQ(length.code, 0) << length.err;
    EXPECT_LT(std::abs(number_of(length.out, "length_mm")), 0.02);
    EXPECT_NEAR(number_of(length.out, "calibrated_mm"), 130, 1e-9);
    EXPECT_TRUE(has(length.out, "these are 1 on 2")) << "fewer lengths than asked for";
}

TEST(VerifyBar, RefusesAnotherBar) {
    const TemporaryFolder folder;
    write_bar_scan(folder / "a.ply", 1, {1, 0.2, 0});
    write_whole_file(folder / "bar.toml",
                     "kind = \"bar\"\ndiameters_mm = [30, 30]\ndiameters_u_mm = [0.001, 0.001]\n"
                     "lengths_mm = [110]\nlengths_u_mm = [0.002]\n");
    const Ended ended = verify({"bar", folder / "a.ply", "--artefact", folder / "bar.toml"});
    EXPECT_EQ(ended.code, 1);
    EXPECT_TRUE(has(ended.err, "the artefact's 110 mm")) << ended.err;
    write_whole_file(folder / "sphere.toml", kSphere);
    const Ended two = verify({"sphere", folder / "a.ply", "--artefact", folder / "sphere.toml"});
    EXPECT_EQ(two.code, 1);
    EXPECT_TRUE(has(two.err, "two spheres")) << two.err;
}

/// A plate before a wall, so far away.
void write_plate_scan(const std::string& path, unsigned seed, double depth_mm) {
    SyntheticRange scene;
    scene.width = 200;
    scene.height = 150;
    scene.focal_px = 300;
    scene.tiles = {{{0, 0, -depth_mm}, {120, 0, 12}, {0, 60, 0}},
                   {{0, 0, -480}, {400, 0, 0}, {0, 300, 0}}};
    write_range_image(path, make_range(scene, seed));
}

TEST(VerifyPlane, TellsFlatness) {
    const TemporaryFolder folder;
    write_plate_scan(folder / "a.ply", 1, 400);
    write_whole_file(folder / "plane.toml",
                     "kind = \"plane\"\nsize_mm = [60, 120.6]\nvolume_diagonal_mm = 300\n");
    const Ended ended = verify({"plane", folder / "a.ply", "--artefact", folder / "plane.toml",
                                "--out", folder / "plane.html", "--json"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_NEAR(number_of(ended.out, "flatness_mm"), 0.058, 0.008);  // 5.9 x 10 um
    EXPECT_NEAR(number_of(ended.out, "sigma_ratio"), 1, 0.05);
    EXPECT_TRUE(
        has(ended.out, "a plane of at least 0.5 of the volume's diagonal; this one has 0.402"));
    EXPECT_TRUE(has(read_whole_file(folder / "plane.html"), "Flatness error"));
}

TEST(VerifyProfile, TellsLinearityAndRepeatability) {
    const TemporaryFolder folder;
    std::vector<std::string> arguments = {"profile"};
    for (int i = 0; i < 4; ++i) {
        const std::string scan = folder / (std::to_string(i) + ".ply");
        write_plate_scan(scan, static_cast<unsigned>(i), 380 + 20 * std::min(i, 2));
        arguments.push_back(scan);
    }
    // The plate travels along z, 5.7 deg from its normal: 20 mm are 19.90 along the normal.
    const double along = 20 * std::cos(std::atan(0.1));
    char text[200];
    std::snprintf(text, sizeof text,
                  "kind = \"travel\"\nsize_mm = [120.6, 60]\ntravelled_mm = [0, %.6f, %.6f, %.6f]\n"
                  "travelled_u_mm = 0.001\n",
                  along, 2 * along, 2 * along);
    write_whole_file(folder / "travel.toml", text);
    for (const std::string more : {"--artefact", "travel.toml", "--out", "page.html"})
        arguments.push_back(more[0] == '-' ? more : folder / more);
    arguments.push_back("--json");
    const Ended ended = verify(arguments);
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_LT(number_of(ended.out, "linearity_mm"), 0.003);
    EXPECT_LT(number_of(ended.out, "repeatability_mm"), 0.003);
    arguments.resize(3);  // two scans, four distances
    for (const std::string more : {"--artefact", "travel.toml"})
        arguments.push_back(more[0] == '-' ? more : folder / more);
    EXPECT_TRUE(has(verify(arguments).err, "found 2 scans"));
}

}  // namespace
}  // namespace stria
