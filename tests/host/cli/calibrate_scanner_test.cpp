#include <gtest/gtest.h>

#include <iostream>
#include <string>
#include <vector>

#include "host/io/certificate.h"
#include "host/io/image_io.h"
#include "host/io/model_io.h"
#include "host/io/whole_file.h"
#include "sim/scene.h"
#include "tests/host/cli/run_stria.h"
#include "tests/host/io/temporary_folder.h"
#include "tests/support/machine_scenes.h"

/// `stria calibrate scanner` as a newcomer runs it: guided on a simulated rail, certificate, scan.
namespace stria {
namespace {

using test_support::Ended;
using test_support::has;
using test_support::run_stria;

class CalibrateScanner : public testing::Test {
  protected:
    CalibrateScanner() {
        auto scenes = test_support::machine_scenes(MachineKind::rail, 4);
        board_ = to_string(scenes.board);
        write_png(folder_ / "board.png", *scenes.board_scene.objects.front().texture_image);
        write_whole_file(folder_ / "board.toml", format_scene(scenes.board_scene));
        write_whole_file(folder_ / "sphere.toml", format_scene(scenes.sphere_scene));
        write_whole_file(folder_ / "board_plan.toml", format_plan(scenes.board_plan));
        write_whole_file(folder_ / "sphere_plan.toml", format_plan(scenes.sphere_plan));
    }
    std::vector<std::string> arguments(const std::vector<std::string>& more) const {
        std::vector<std::string> all = {"calibrate",
                                        "scanner",
                                        "sim:" + (folder_ / "board.toml"),
                                        "--board",
                                        board_,
                                        "--plan",
                                        folder_ / "board_plan.toml",
                                        "--out",
                                        folder_ / "scanner.toml"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }

    TemporaryFolder folder_;
    std::string board_;
};

TEST_F(CalibrateScanner, RefusesOptionsThatMeanNothing) {
    for (const auto& [option, value] :
         std::vector<std::pair<std::string, std::string>>{{"--check", "1"},
                                                          {"--check", "-2"},
                                                          {"--valid-days", "0"},
                                                          {"--views", "2"},
                                                          {"--temperature", "900"}}) {
        const Ended said = run_stria(arguments({option, value}));
        EXPECT_EQ(said.code, 1) << option;
        EXPECT_TRUE(has(said.err, option)) << said.err;
        EXPECT_TRUE(has(said.err, "expected")) << said.err;
    }
    const Ended no_texture = run_stria({"calibrate", "scanner", "sim:" + (folder_ / "sphere.toml"),
                                        "--board", board_, "--plan", folder_ / "board_plan.toml",
                                        "--out", folder_ / "scanner.toml", "--guided"});
    EXPECT_EQ(no_texture.code, 1);
    EXPECT_TRUE(has(no_texture.err, "no object has a texture")) << no_texture.err;
}

#ifdef STRIA_LONG
TEST_F(CalibrateScanner, GuidesChecksCertifiesAndScanReadsIt) {
    const std::string out = folder_ / "scanner.toml";
    const Ended first = run_stria(arguments({"--guided", "--views", "10", "--temperature", "21"}));
    std::cout << first.out << first.err << std::endl;
    ASSERT_EQ(first.code, 0) << first.err;
    EXPECT_TRUE(has(first.out, "view 10: hold the board")) << first.out;
    EXPECT_TRUE(has(first.out, "certificate: passed")) << first.out;
    EXPECT_TRUE(has(read_whole_file(out + ".guide.svg"), "</svg>"));
    const auto certificate = read_certificate(out);
    ASSERT_TRUE(certificate);
    EXPECT_EQ(certificate->status, CertificateStatus::passed);
    EXPECT_EQ(certificate->check_views, 2);
    EXPECT_EQ(certificate->views, 8);
    EXPECT_EQ(certificate->temperature_c, 21);
    EXPECT_EQ(certificate->date, "");  // simulated: the same bytes any day
    EXPECT_EQ(certificate->data_hash, read_scanner(out).provenance.data_hash);

    EXPECT_EQ(run_stria(arguments({"--views", "9"})).code, 1);  // it is there already
    const Ended again = run_stria(arguments({"--views", "9", "--force", "--board-warp"}));
    std::cout << again.out << again.err << std::endl;
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_TRUE(has(again.out, "points moved by")) << again.out;
    EXPECT_TRUE(has(again.out, "the board bulges by")) << again.out;
    EXPECT_TRUE(has(again.out, "certificate: unchecked")) << again.out;  // 9 views: none to spare

    const Ended scan =
        run_stria({"scan", "sim:" + (folder_ / "sphere.toml"), "--plan",
                   folder_ / "sphere_plan.toml", "--model", out, "--out", folder_ / "part"});
    EXPECT_EQ(scan.code, 0) << scan.err;
    EXPECT_TRUE(has(scan.out, "warning: the calibration was not checked")) << scan.out;
    EXPECT_TRUE(read_certificate(folder_ / "part/scanner.toml"));
}
#endif

}  // namespace
}  // namespace stria
