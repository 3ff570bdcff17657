#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "calib/linear_view.h"
#include "host/cli/scan_notes.h"
#include "host/core/errors.h"
#include "host/io/certificate.h"
#include "host/io/model_io.h"
#include "host/io/whole_file.h"
#include "sim/scene.h"
#include "tests/host/cli/run_stria.h"
#include "tests/host/io/temporary_folder.h"
#include "tests/support/machine_scenes.h"

/// `stria scan --check` on a simulated scanner with a sphere in view, before and after a knock.
namespace stria {
namespace {

using test_support::Ended;
using test_support::has;
using test_support::run_stria;

ScanNotes some_notes() {
    ScanNotes notes;
    notes.model_hash = "12ab";
    notes.temperature_c = 21.5;
    notes.artefact = "a \"plate\"";
    notes.check = ShapeCheck{"plane", shape_figures("plane"), {}, {}, {}};
    notes.check->figures[1].off_mm = -0.0125;
    notes.check->noise = Eigen::Matrix3d::Identity() * 1e-6;
    notes.check->calibration = Eigen::Vector3d(1e-5, 2e-5, 3e-5).asDiagonal();
    notes.check->artefact = Eigen::Matrix3d::Zero();
    return notes;
}

std::string refusal(std::string text, const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
    try {
        parse_scan_notes(text, "scan.toml");
    } catch (const FileError& error) {
        return error.what();
    }
    return {};
}

TEST(ScanNotes, RoundTripIsExact) {
    const std::string text = format_scan_notes(some_notes());
    EXPECT_EQ(format_scan_notes(parse_scan_notes(text, "scan.toml")), text);
    EXPECT_EQ(parse_scan_notes(text, "scan.toml").check->figures[1].off_mm, -0.0125);
    const std::string bare = format_scan_notes({"", {}, "", {}});
    EXPECT_EQ(format_scan_notes(parse_scan_notes(bare, "scan.toml")), bare);
}

TEST(ScanNotes, RefuseWhatMakesNoSense) {
    const std::string text = format_scan_notes(some_notes());
    EXPECT_TRUE(has(refusal(text, "\"plane\"\n", "\"cone\"\n"), "sphere or plane"));
    EXPECT_TRUE(has(refusal(text, "\"plane\"\n", "\"sphere\"\n"), "off_mm"));
    EXPECT_TRUE(has(refusal(text, "2e-05", "-2e-05"), "variance")) << text;
    EXPECT_TRUE(has(refusal(text, "temperature_c", "temprature_c"), "temprature_c"));
}

class CheckedScan : public testing::Test {
  protected:
    CheckedScan() {
        const auto scenes = test_support::machine_scenes(MachineKind::swept, 4);
        write_whole_file(folder_ / "sphere.toml", format_scene(scenes.sphere_scene));
        write_whole_file(folder_ / "plan.toml", format_plan(scenes.sphere_plan));
        Scene knocked = scenes.sphere_scene;
        knocked.channel.camera.fx *= 1.01;
        knocked.channel.camera.fy *= 1.01;
        write_whole_file(folder_ / "knocked.toml", format_scene(knocked));
        ScannerModel model;
        model.channels = {scenes.sphere_scene.channel};
        // A calibration that knows each parameter to a thousandth of what the drawing does.
        model.covariance = 1e-6 * drawing_covariance(model);
        Certificate certificate;
        certificate.status = CertificateStatus::passed;
        certificate.temperature_c = 20;
        write_scanner(folder_ / "scanner.toml", model, certificate);
        write_whole_file(folder_ / "ball.toml",
                         "kind = \"sphere\"\nname = \"ball\"\ndiameter_mm = 50.0\n"
                         "diameter_u_mm = 0.2\n");
    }
    Ended scan(const std::string& scene, const std::vector<std::string>& more) const {
        std::vector<std::string> all = {
            "scan",    "sim:" + (folder_ / scene), "--plan", folder_ / "plan.toml",
            "--model", folder_ / "scanner.toml",   "--out",  folder_ / "part"};
        all.insert(all.end(), more.begin(), more.end());
        return run_stria(all);
    }

    TemporaryFolder folder_;
};

TEST_F(CheckedScan, TellsAKnockFromWhatTheCalibrationExpects) {
    const std::string ball = folder_ / "ball.toml";
    const Ended first =
        scan("sphere.toml", {"--check", ball, "--check-as-reference", "--temperature", "21"});
    ASSERT_EQ(first.code, 0) << first.err;
    EXPECT_TRUE(has(first.out, "diameter of the sphere off by")) << first.out;
    EXPECT_TRUE(has(first.out, "from the artefact's certificate")) << first.out;
    EXPECT_FALSE(has(first.out, "2 sigma")) << first.out;
    EXPECT_FALSE(has(first.out, "not judged")) << first.out;
    const ScanNotes notes = read_scan_notes(folder_ / "part/scans/0001/scan.toml");
    EXPECT_EQ(notes.temperature_c, 21);
    ASSERT_TRUE(notes.check);
    EXPECT_EQ(read_whole_file(folder_ / "part/check.toml"),
              read_whole_file(folder_ / "part/scans/0001/scan.toml"));

    const Ended same = scan("sphere.toml", {"--check", ball, "--temperature", "27", "--seed", "2"});
    EXPECT_EQ(same.code, 0) << same.err;
    EXPECT_TRUE(has(same.out, "since the reference")) << same.out;
    EXPECT_FALSE(has(same.out, "2 sigma")) << same.out;
    EXPECT_TRUE(has(same.out, "calibrated at 20 degrees Celsius, now at 27")) << same.out;

    const Ended knocked = scan("knocked.toml", {"--check", ball, "--json"});
    EXPECT_EQ(knocked.code, 0) << knocked.err;
    EXPECT_TRUE(has(knocked.err, "by more than 2 sigma")) << knocked.err;
    EXPECT_TRUE(has(knocked.out, "\"drifted\": true")) << knocked.out;
    EXPECT_TRUE(has(knocked.out, "\"against\": \"reference\"")) << knocked.out;

    std::filesystem::remove(folder_ / "part/check.toml");
    const Ended alone = scan("knocked.toml", {"--check", ball, "--json"});
    EXPECT_EQ(alone.code, 0) << alone.err;
    EXPECT_TRUE(has(alone.err, "drift is not judged")) << alone.err;
    EXPECT_FALSE(has(alone.err, "2 sigma")) << alone.err;
    EXPECT_FALSE(has(alone.out, "drifted")) << alone.out;
}

TEST_F(CheckedScan, RefusesBeforeItScans) {
    const Ended alone = scan("sphere.toml", {"--check-as-reference"});
    EXPECT_EQ(alone.code, 1);
    EXPECT_TRUE(has(alone.err, "expected --check")) << alone.err;
    write_whole_file(folder_ / "bar.toml", "kind = \"bar\"\n");
    const Ended bar = scan("sphere.toml", {"--check", folder_ / "bar.toml"});
    EXPECT_EQ(bar.code, 1);
    EXPECT_TRUE(has(bar.err, "expected \"sphere\" or \"plane\"")) << bar.err;
    const Ended hot = scan("sphere.toml", {"--temperature", "warm"});
    EXPECT_EQ(hot.code, 1);
    EXPECT_TRUE(has(hot.err, "--temperature warm")) << hot.err;
    const Ended none = run_stria({"scan", "sim:" + (folder_ / "sphere.toml"), "--out",
                                  folder_ / "other", "--check", folder_ / "ball.toml"});
    EXPECT_EQ(none.code, 1);
    EXPECT_TRUE(has(none.err, "without a calibration")) << none.err;
}

}  // namespace
}  // namespace stria
