#include <gtest/gtest.h>

#include <iostream>
#include <string>
#include <vector>

#include "host/cli/run.h"
#include "host/io/certificate.h"
#include "host/io/image_io.h"
#include "host/io/model_io.h"
#include "host/io/whole_file.h"
#include "sim/scene.h"
#include "tests/host/io/temporary_folder.h"
#include "tests/support/machine_scenes.h"

/// `stria calibrate scanner` as a newcomer runs it: guided on a simulated rail, certificate, scan.
namespace stria {
namespace {

struct Said {
    int code = 0;
    std::string out, err;
};

Said stria(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv = {"stria"};
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    Said said;
    said.code = run_program(static_cast<int>(argv.size()), argv.data());
    said.out = testing::internal::GetCapturedStdout();
    said.err = testing::internal::GetCapturedStderr();
    return said;
}

bool says(const std::string& text, const std::string& what) {
    return text.find(what) != std::string::npos;
}

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
        const Said said = stria(arguments({option, value}));
        EXPECT_EQ(said.code, 1) << option;
        EXPECT_TRUE(says(said.err, option)) << said.err;
        EXPECT_TRUE(says(said.err, "expected")) << said.err;
    }
    const Said no_texture = stria({"calibrate", "scanner", "sim:" + (folder_ / "sphere.toml"),
                                   "--board", board_, "--plan", folder_ / "board_plan.toml",
                                   "--out", folder_ / "scanner.toml", "--guided"});
    EXPECT_EQ(no_texture.code, 1);
    EXPECT_TRUE(says(no_texture.err, "no object has a texture")) << no_texture.err;
}

#ifdef STRIA_LONG
TEST_F(CalibrateScanner, GuidesChecksCertifiesAndScanReadsIt) {
    const std::string out = folder_ / "scanner.toml";
    const Said first = stria(arguments({"--guided", "--views", "10", "--temperature", "21"}));
    std::cout << first.out << first.err << std::endl;
    ASSERT_EQ(first.code, 0) << first.err;
    EXPECT_TRUE(says(first.out, "view 10: hold the board")) << first.out;
    EXPECT_TRUE(says(first.out, "certificate: passed")) << first.out;
    EXPECT_TRUE(says(read_whole_file(out + ".guide.svg"), "</svg>"));
    const auto certificate = read_certificate(out);
    ASSERT_TRUE(certificate);
    EXPECT_EQ(certificate->status, CertificateStatus::passed);
    EXPECT_EQ(certificate->check_views, 2);
    EXPECT_EQ(certificate->views, 8);
    EXPECT_EQ(certificate->temperature_c, 21);
    EXPECT_EQ(certificate->date, "");  // simulated: the same bytes any day
    EXPECT_EQ(certificate->data_hash, read_scanner(out).provenance.data_hash);

    EXPECT_EQ(stria(arguments({"--views", "9"})).code, 1);  // it is there already
    const Said again = stria(arguments({"--views", "9", "--force"}));
    std::cout << again.out << again.err << std::endl;
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_TRUE(says(again.out, "points moved by")) << again.out;
    EXPECT_TRUE(says(again.out, "certificate: unchecked")) << again.out;  // 9 views: none to spare

    const Said scan =
        stria({"scan", "sim:" + (folder_ / "sphere.toml"), "--plan", folder_ / "sphere_plan.toml",
               "--model", out, "--out", folder_ / "part"});
    EXPECT_EQ(scan.code, 0) << scan.err;
    EXPECT_TRUE(says(scan.out, "warning: the calibration was not checked")) << scan.out;
    EXPECT_TRUE(read_certificate(folder_ / "part/scanner.toml"));
}
#endif

}  // namespace
}  // namespace stria
