#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/stripe/peak_methods.h"
#include "host/cli/run.h"
#include "host/core/frame_image.h"
#include "host/io/image_io.h"
#include "host/io/model_io.h"
#include "host/io/range_io.h"
#include "host/io/whole_file.h"
#include "sim/scene.h"
#include "tests/firmware/stripe/localisation.h"
#include "tests/firmware/stripe/row_frames.h"
#include "tests/host/io/temporary_folder.h"

/// The verb on the images of `stria simulate --frames`, against the scene's own truth.
namespace stria {
namespace {

int stria(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv = {"stria"};
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    return run_program(static_cast<int>(argv.size()), argv.data());
}

/// The middle of the built-in scene's camera.
Scene small_scene() {
    Scene scene = built_in_scene();
    CameraModel& camera = scene.channel.camera;
    camera.width = 320;
    camera.height = 240;
    camera.cx -= 240;
    camera.cy -= 200;
    return scene;
}

struct FoundPulse {
    int u = 0, v = 0;
    double s = 0, amplitude = 0, width_s = 0, sigma_s = 0;
    int flags = 0;
};

std::vector<FoundPulse> read_pulses(const std::string& csv) {
    std::istringstream in(read_whole_file(csv));
    std::string line;
    std::getline(in, line);
    EXPECT_EQ(line, "u,v,s,amplitude,width_s,sigma_s,flags");
    std::vector<FoundPulse> pulses;
    while (std::getline(in, line)) {
        FoundPulse p;
        EXPECT_EQ(std::sscanf(line.c_str(), "%d,%d,%lf,%lf,%lf,%lf,%d", &p.u, &p.v, &p.s,
                              &p.amplitude, &p.width_s, &p.sigma_s, &p.flags),
                  7)
            << line;
        pulses.push_back(p);
    }
    return pulses;
}

std::vector<std::string> frames_in(const std::string& folder) {
    std::vector<std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().filename().string().rfind("frame_", 0) == 0)
            files.push_back(entry.path().string());
    std::sort(files.begin(), files.end());
    return files;
}

std::vector<double> numbers_in(const std::string& file) {
    std::istringstream in(read_whole_file(file));
    std::vector<double> numbers;
    for (double number = 0; in >> number;) numbers.push_back(number);
    return numbers;
}

/// One surface all around: no cell within 3 px is empty or leaves the middle one's tangent plane by
/// more than the beam's width.
bool is_interior(const RangeImage& truth, int x, int y) {
    constexpr int kReach = 3;
    if (x < kReach || y < kReach || x + kReach >= truth.width || y + kReach >= truth.height)
        return false;
    const RangePoint& here = truth.at(x, y);
    for (int dy = -kReach; dy <= kReach; ++dy)
        for (int dx = -kReach; dx <= kReach; ++dx) {
            if (!truth.has(x + dx, y + dy)) return false;
            const RangePoint& there = truth.at(x + dx, y + dy);
            if (std::abs(here.normal.cast<double>().dot(there.position - here.position)) > 0.25)
                return false;
        }
    return true;
}

struct Outcome {
    test::LocalisationCell cell;
    std::size_t pulses = 0, flagged = 0, compared = 0;
};

/// Every unflagged interior pulse against the truth; the bound from the sensor's true noise and the
/// pulse's own height and width.
Outcome compare_to_truth(const TemporaryFolder& folder, const Scene& scene) {
    const RangeImage truth = read_range_image(folder / "sweep/truth.ply");
    const Channel channel = read_scanner(folder / "sweep/truth_scanner.toml").channels.front();
    const std::vector<double> times = numbers_in(folder / "sweep/times.txt");
    const double exposure_frames =
        scene.sensor.exposure_us / scene.sensor.min_frame_period_us;  // as the plan runs it
    const double background_dn =
        scene.sensor.black_dn + 0.5 * scene.ambient_level * 255;  // albedo about a half
    const SensorNoise noise{scene.sensor.gain_e_per_dn, scene.sensor.read_noise_e,
                            scene.sensor.black_dn};
    Outcome outcome;
    test::LocalisationTally tally;
    const std::vector<FoundPulse> pulses = read_pulses(folder / "pulses.csv");
    outcome.pulses = pulses.size();
    for (const FoundPulse& p : pulses) {
        if ((p.flags & ~kPulseSaturated) != 0) {
            ++outcome.flagged;
            continue;
        }
        if (!truth.has(p.u, p.v) || !is_interior(truth, p.u, p.v)) continue;
        const auto at = triangulate(channel, Eigen::Vector2d(p.u, p.v), p.s);
        EXPECT_TRUE(at.has_value());
        if (!at) continue;
        const Eigen::Vector3d off = at->point_in_scan - truth.at(p.u, p.v).position;
        const double error_s = off.dot(at->d_point_d_s) / at->d_point_d_s.squaredNorm();
        // Position in frames, from the one before the pulse.
        const auto next = std::lower_bound(times.begin(), times.end(), p.s) - times.begin();
        const std::ptrdiff_t middle = std::clamp<std::ptrdiff_t>(next, 1, std::ssize(times) - 1);
        const double period_s = times[middle] - times[middle - 1];
        std::vector<double> x;
        for (std::ptrdiff_t k = std::max<std::ptrdiff_t>(0, middle - 12);
             k < std::min<std::ptrdiff_t>(std::ssize(times), middle + 12); ++k)
            x.push_back((times[k] - p.s) / period_s);
        const double bound =
            test::cramer_rao_bound({p.amplitude, 0, p.width_s / period_s, background_dn}, x,
                                   0.5 * exposure_frames, noise, 254.5);
        ++outcome.compared;
        tally.add(error_s / period_s, p.sigma_s / period_s, bound);
    }
    outcome.cell = tally.cell();
    return outcome;
}

TEST(Stripe, SimulatedFramesReachTheBoundWithHonestSigma) {
    const TemporaryFolder folder;
    const Scene scene = small_scene();
    write_whole_file(folder / "scene.toml", format_scene(scene));
    ASSERT_EQ(stria({"simulate", folder / "scene.toml", "--out", folder / "sweep", "--frames",
                     "--quiet"}),
              0);
    for (const std::string noise : {"40,8", ""}) {
        std::vector<std::string> arguments = {"stripe",
                                              "--mode",
                                              "spacetime",
                                              "--quiet",
                                              "--force",
                                              "--out",
                                              folder / "pulses.csv",
                                              "--times",
                                              folder / "sweep/times.txt"};
        if (!noise.empty()) arguments.insert(arguments.end(), {"--noise", noise});
        for (const std::string& file : frames_in(folder / "sweep")) arguments.push_back(file);
        ASSERT_EQ(stria(arguments), 0);
        const Outcome outcome = compare_to_truth(folder, scene);
        std::printf(
            "noise %-6s %zu pulses, %zu flagged, %zu compared: rms / bound %.4f, sigma ratio %.4f, "
            "bound %.5f "
            "rms %.5f mean %.5f\n",
            noise.empty() ? "estimated" : noise.c_str(), outcome.pulses, outcome.flagged,
            outcome.compared, outcome.cell.ratio(), outcome.cell.sigma_ratio, outcome.cell.bound,
            outcome.cell.rms, outcome.cell.mean);
        EXPECT_GT(outcome.compared, 50000U);
        EXPECT_LT(outcome.flagged, outcome.pulses / 40);
        EXPECT_LE(outcome.cell.ratio(), 1.1);
        EXPECT_GE(outcome.cell.sigma_ratio, 0.8);
        EXPECT_LE(outcome.cell.sigma_ratio, 1.25);
    }
}

// A straight stripe of known place.
constexpr double kAt = 40.3, kWidthPx = 1.5;

void write_stripe(const std::string& file) {
    const SensorNoise noise = test::sensor_for(180, 40, false);
    const Frame frame = test::frame_of(80, 60, 8, {{180, kAt, kWidthPx, 20}}, noise, 3);
    GreyImage image;
    image.width = frame.width;
    image.height = frame.height;
    image.values = frame.bytes;
    write_png(file, image);
}

double mean_u(const std::string& csv) {
    std::istringstream in(read_whole_file(csv));
    std::string line;
    std::getline(in, line);
    double sum = 0;
    int count = 0;
    for (; std::getline(in, line); ++count) sum += std::stod(line.substr(line.find(',') + 1));
    EXPECT_EQ(count, 60);
    return sum / count;
}

TEST(StripeMethod, PutsThePeaksWhereItIsNamedFor) {
    const TemporaryFolder folder;
    write_stripe(folder / "stripe.png");
    std::vector<std::string> answers;
    for (const PeakMethod method : kPeakMethods) {
        const std::string csv = folder / (std::string(name_of(method)) + ".csv");
        ASSERT_EQ(stria({"stripe", folder / "stripe.png", "--method", std::string(name_of(method)),
                         "--out", csv, "--noise", "1e9,4.5e9", "--quiet"}),
                  0);
        // Steger's bias is below 0.03 px; sigma of the mean of 60 rows below 0.01 px
        EXPECT_NEAR(mean_u(csv), kAt, 0.06) << name_of(method);
        answers.push_back(read_whole_file(csv));
    }
    for (std::size_t i = 0; i < answers.size(); ++i)
        for (std::size_t k = i + 1; k < answers.size(); ++k) EXPECT_NE(answers[i], answers[k]);
}

TEST(StripeAxis, IsNamedWhereTheStripeRunsTheOtherWay) {
    const TemporaryFolder folder;
    write_stripe(folder / "stripe.png");
    const auto said = [&](const std::string& axis) {
        testing::internal::CaptureStdout();
        EXPECT_EQ(stria({"stripe", folder / "stripe.png", "--axis", axis, "--out",
                         folder / (axis + ".csv"), "--noise", "1e9,4.5e9"}),
                  0);
        return testing::internal::GetCapturedStdout();
    };
    EXPECT_NE(said("columns").find("--axis rows finds 60 peaks"), std::string::npos);
    EXPECT_EQ(said("rows").find("finds"), std::string::npos);
}

TEST(StripeDeconvolve, SharpensPulsesOverTimeAndSaysItsPrice) {
    const TemporaryFolder folder;
    std::vector<std::string> arguments = {"stripe", "--mode",  "spacetime",
                                          "--json", "--noise", "40,8"};
    // A stripe that moves a third of its width a frame, to the right.
    for (int k = 0; k < 60; ++k) {
        const double at = 10.0 + k;
        GreyImage image(80, 4);
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 80; ++x)
                image.at(x, y) = static_cast<std::uint8_t>(
                    std::lround(20 + 180 * std::exp(-0.5 * std::pow((x - at) / 3.0, 2))));
        char name[16];
        std::snprintf(name, sizeof name, "%03d.png", k);
        write_png(folder / name, image);
        arguments.push_back(folder / name);
    }
    for (const std::string wish : {"", "0.8,0.55", "fast"}) {
        const bool sharper = wish == "0.8,0.55";
        std::vector<std::string> all = arguments;
        all.insert(all.end(), {"--out", folder / ("pulses" + wish + ".csv")});
        if (sharper) all.insert(all.end(), {"--deconvolve", wish});
        if (wish == "fast") all.push_back("--fast");
        testing::internal::CaptureStdout();
        ASSERT_EQ(stria(all), 0);
        const std::string json = testing::internal::GetCapturedStdout();
        EXPECT_EQ(json.find("noise_gain") != std::string::npos, sharper);
        const std::vector<FoundPulse> pulses = read_pulses(folder / ("pulses" + wish + ".csv"));
        int compared = 0;
        for (const FoundPulse& p : pulses) {
            if (p.u < 25 || p.u > 55) continue;
            ++compared;
            EXPECT_NEAR(p.s, p.u - 10.0, 0.02);
            // The footprint's part of the width goes: sqrt(9 - 0.64 + 0.3025).
            EXPECT_NEAR(p.width_s, sharper ? 2.943 : 3.0, 0.02);
            EXPECT_NEAR(p.amplitude, sharper ? 183.5 : 180, 1.5);
        }
        EXPECT_EQ(compared, 31 * 4);
    }
    testing::internal::CaptureStderr();
    EXPECT_NE(
        stria({"stripe", folder / "000.png", "--deconvolve", "0.8,0.55", "--out", folder / "x"}),
        0);
    EXPECT_NE(stria({"stripe", folder / "000.png", "--mode", "spacetime", "--deconvolve", "0.8",
                     "--out", folder / "x"}),
              0);
    EXPECT_NE(stria({"stripe", folder / "000.png", "--fast", "--out", folder / "x"}), 0);
    const std::string errors = testing::internal::GetCapturedStderr();
    EXPECT_NE(errors.find("--fast: expected --mode spacetime"), std::string::npos);
    EXPECT_NE(errors.find("--deconvolve: expected --mode spacetime"), std::string::npos);
    EXPECT_NE(errors.find("expected FOOTPRINT,TARGET"), std::string::npos);
}

TEST(StripeMethod, IsRefusedOverTimeAndWhenUnknown) {
    const TemporaryFolder folder;
    write_stripe(folder / "stripe.png");
    const std::string image = folder / "stripe.png", out = folder / "out.csv";
    testing::internal::CaptureStderr();
    EXPECT_NE(stria({"stripe", image, "--mode", "spacetime", "--method", "cog", "--out", out}), 0);
    const std::string message = testing::internal::GetCapturedStderr();
    EXPECT_NE(message.find("--method cog: expected ml with --mode spacetime"), std::string::npos)
        << message;
    EXPECT_FALSE(std::filesystem::exists(out));
    EXPECT_NE(stria({"stripe", image, "--method", "gauss", "--out", out}), 0);
}

}  // namespace
}  // namespace stria
