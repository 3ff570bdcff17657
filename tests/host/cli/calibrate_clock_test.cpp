#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <string>
#include <vector>

#include "host/io/model_io.h"
#include "host/io/whole_file.h"
#include "sim/scene.h"
#include "tests/host/cli/run_stria.h"
#include "tests/host/io/temporary_folder.h"
#include "tests/sim/plate_scene.h"
#include "tests/support/machine_scenes.h"

/// `stria calibrate clock` on simulated machines whose axes lag their logs.
namespace stria {
namespace {

using test_support::Ended;
using test_support::has;
using test_support::number_of;
using test_support::run_stria;

/// A sphere before a machine, in files.
class SphereScene {
  public:
    explicit SphereScene(MachineKind kind) : scenes_(test_support::machine_scenes(kind, 4)) {
        CameraModel& camera = scenes_.sphere_scene.channel.camera;
        test::crop_to_middle(camera, camera.width, 80);
        if (kind == MachineKind::swept) return;
        scenes_.sphere_plan.from *= 0.4;
        scenes_.sphere_plan.to *= 0.4;
    }
    Scene& scene() { return scenes_.sphere_scene; }
    ScanPlan& plan() { return scenes_.sphere_plan; }
    std::string path(const std::string& name) const { return folder_ / name; }

    Ended clock(const std::vector<std::string>& more) const {
        write_whole_file(path("scene.toml"), format_scene(scenes_.sphere_scene));
        write_whole_file(path("plan.toml"), format_plan(scenes_.sphere_plan));
        std::vector<std::string> all = {"calibrate", "clock", "sim:" + path("scene.toml"), "--plan",
                                        path("plan.toml")};
        all.insert(all.end(), more.begin(), more.end());
        return run_stria(all);
    }

  private:
    TemporaryFolder folder_;
    test_support::MachineScenes scenes_;
};

class ClockOf : public testing::TestWithParam<MachineKind> {};

TEST_P(ClockOf, FindsHowFarTheAxisLagsItsLog) {
    SphereScene sphere(GetParam());
    sphere.scene().axis.lag_us = 400;
    const std::string out = sphere.path("clocked.toml");
    const Ended ended = sphere.clock({"--sweeps", "2", "--json", "--out", out});
    ASSERT_EQ(ended.code, 0) << ended.err;
    std::cout << ended.err;
    const double delay_ns = number_of(ended.out, "delay_ns");
    const double sigma_ns = number_of(ended.out, "sigma_ns");
    EXPECT_NEAR(delay_ns, -400e3, 4 * sigma_ns);
    EXPECT_LT(sigma_ns, 40e3);
    const ScannerModel design = read_scanner(out);
    EXPECT_DOUBLE_EQ(design.channels.front().axis.delay_ns, delay_ns);
    EXPECT_EQ(design.channels.front().axis.kind, GetParam());
    EXPECT_EQ(sphere.clock({"--sweeps", "1", "--out", out}).code, 1);  // it is there already
}

INSTANTIATE_TEST_SUITE_P(Machines, ClockOf,
                         testing::Values(MachineKind::swept, MachineKind::rail,
                                         MachineKind::turntable),
                         [](const auto& machine) { return std::string(name_of(machine.param)); });

void expect_refused(const Ended& ended, const std::string& why) {
    EXPECT_EQ(ended.code, 1);
    EXPECT_TRUE(has(ended.err, why)) << ended.err;
    EXPECT_TRUE(has(ended.err, "expected")) << ended.err;
}

TEST(CalibrateClock, RefusesWhatTellsNothing) {
    SphereScene sphere(MachineKind::rail);
    sphere.plan().from = -20;
    sphere.plan().to = 20;
    expect_refused(sphere.clock({"--sweeps", "0"}), "--sweeps 0");
    expect_refused(sphere.clock({"--nominal", "design.toml"}), "--nominal without --out");

    ScannerModel calibrated;
    calibrated.channels = {sphere.scene().channel};
    const auto size = static_cast<Eigen::Index>(parameter_names(calibrated).size());
    calibrated.covariance = 1e-6 * Eigen::MatrixXd::Identity(size, size);
    write_scanner(sphere.path("calibrated.toml"), calibrated);
    expect_refused(
        sphere.clock({"--nominal", sphere.path("calibrated.toml"), "--out", sphere.path("out")}),
        "is a calibrated model");

    const Ended scan = run_stria({"scan", "sim:" + sphere.path("scene.toml"), "--plan",
                                  sphere.path("plan.toml"), "--out", sphere.path("part")});
    ASSERT_EQ(scan.code, 0) << scan.err;
    expect_refused(
        run_stria({"calibrate", "clock", sphere.path("part/scans/0001/recording.stria")}),
        "swept in one direction");

    expect_refused(run_stria({"calibrate", "clock", sphere.path("part/scans/0001/recording.stria"),
                              "--sweeps", "2"}),
                   "--sweeps belong to a device");

    sphere.plan().mode = StripeMode::spacetime;
    sphere.plan().record = RecordWhat::frames;
    expect_refused(sphere.clock({"--sweeps", "1"}), "mode = \"spatial\"");
    sphere.plan().mode = StripeMode::spatial;
    sphere.scene().objects.clear();
    expect_refused(sphere.clock({"--sweeps", "1"}), "something at rest in view");
}

}  // namespace
}  // namespace stria
