#include "host/io/model_io.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "host/core/errors.h"
#include "host/io/number_text.h"
#include "host/io/whole_file.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

/// Doubles of every size, none of them short in decimals.
struct Numbers {
    std::mt19937 rng{11};
    double any() {
        std::uniform_real_distribution<double> mantissa(-1, 1), exponent(-20, 20);
        return mantissa(rng) * std::pow(10.0, exponent(rng));
    }
    double positive() { return std::abs(any()) + 1e-30; }
    Eigen::Vector3d vector() { return {any(), any(), any()}; }
    Eigen::Vector3d unit() {
        std::normal_distribution<double> normal;
        return Eigen::Vector3d(normal(rng), normal(rng), normal(rng)).normalized();
    }
    Rigid3 motion() { return {rotation_from_vector(2.0 * unit()), vector()}; }
    CameraModel camera(LensKind kind) {
        CameraModel camera{kind, 1280, 1024, positive(), positive(), any(), any(), {}};
        for (int i = 0; i < distortion_count(kind); ++i)
            camera.distortion[static_cast<std::size_t>(i)] = any();
        return camera;
    }
    LaserSheet sheet() {
        return {unit(), any(),      vector(),   unit(), any(),
                any(),  positive(), positive(), any(),  positive()};
    }
};

ScannerModel random_model(Numbers& n, MachineKind kind) {
    ScannerModel model;
    for (std::uint8_t i = 0; i < 2; ++i) {
        Channel channel;
        channel.camera_id = i;
        channel.laser_id = static_cast<std::uint8_t>(3 - i);
        channel.camera = n.camera(i == 0 ? LensKind::brown5 : LensKind::rational8);
        channel.sheet = n.sheet();
        channel.axis.kind = kind;
        if (kind == MachineKind::swept)
            channel.axis.mirror = {n.unit(), n.vector(), n.unit(), n.any(), n.any(), n.any()};
        if (kind == MachineKind::rail) channel.axis.rail.direction = n.unit();
        if (kind == MachineKind::turntable) channel.axis.turntable.table_from_camera = n.motion();
        channel.axis.delay_ns = n.any();
        model.channels.push_back(channel);
    }
    const auto count = static_cast<Eigen::Index>(parameter_names(model).size());
    model.covariance = Eigen::MatrixXd(count, count);
    for (double& value : model.covariance.reshaped()) value = n.any();
    model.volume = {Eigen::Vector3d(-0.1, -1.0 / 3, -7), Eigen::Vector3d(0.1, 1.0 / 3, 7)};
    model.provenance = {"stria \"x\\y\"\n", "2026-11-22", "ab12", 1.0 / 3};
    return model;
}

void expect_same(const CameraModel& a, const CameraModel& b) {
    EXPECT_EQ(a.kind, b.kind);
    EXPECT_EQ(a.width, b.width);
    EXPECT_EQ(a.height, b.height);
    EXPECT_EQ(a.fx, b.fx);
    EXPECT_EQ(a.fy, b.fy);
    EXPECT_EQ(a.cx, b.cx);
    EXPECT_EQ(a.cy, b.cy);
    EXPECT_EQ(a.distortion, b.distortion);
}

void expect_same(const Channel& a, const Channel& b) {
    EXPECT_EQ(a.camera_id, b.camera_id);
    EXPECT_EQ(a.laser_id, b.laser_id);
    expect_same(a.camera, b.camera);
    EXPECT_EQ(a.sheet.normal, b.sheet.normal);
    EXPECT_EQ(a.sheet.offset_mm, b.sheet.offset_mm);
    EXPECT_EQ(a.sheet.apex, b.sheet.apex);
    EXPECT_EQ(a.sheet.central_ray, b.sheet.central_ray);
    EXPECT_EQ(a.sheet.bow2, b.sheet.bow2);
    EXPECT_EQ(a.sheet.bow3, b.sheet.bow3);
    EXPECT_EQ(a.sheet.fan_rad, b.sheet.fan_rad);
    EXPECT_EQ(a.sheet.waist_sigma_mm, b.sheet.waist_sigma_mm);
    EXPECT_EQ(a.sheet.waist_at_mm, b.sheet.waist_at_mm);
    EXPECT_EQ(a.sheet.wavelength_nm, b.sheet.wavelength_nm);
    EXPECT_EQ(a.axis.kind, b.axis.kind);
    EXPECT_EQ(a.axis.mirror.direction, b.axis.mirror.direction);
    EXPECT_EQ(a.axis.mirror.point, b.axis.mirror.point);
    EXPECT_EQ(a.axis.mirror.normal0, b.axis.mirror.normal0);
    EXPECT_EQ(a.axis.mirror.offset_mm, b.axis.mirror.offset_mm);
    EXPECT_EQ(a.axis.mirror.g2, b.axis.mirror.g2);
    EXPECT_EQ(a.axis.mirror.g3, b.axis.mirror.g3);
    EXPECT_EQ(a.axis.rail.direction, b.axis.rail.direction);
    EXPECT_EQ(a.axis.turntable.table_from_camera.rotation,
              b.axis.turntable.table_from_camera.rotation);
    EXPECT_EQ(a.axis.turntable.table_from_camera.translation,
              b.axis.turntable.table_from_camera.translation);
    EXPECT_EQ(a.axis.delay_ns, b.axis.delay_ns);
}

TEST(NumberText, RoundTripsEveryBit) {
    std::mt19937_64 rng(3);
    for (int i = 0; i < 20000; ++i) {
        const std::uint64_t bits = rng();
        double value;
        std::memcpy(&value, &bits, 8);
        if (!std::isfinite(value)) continue;
        std::string text;
        append_number(text, value);
        EXPECT_EQ(parse_number(text), value) << text;
    }
}

TEST(NumberText, TakesWhatPeopleWrite) {
    EXPECT_EQ(parse_number("+1.5"), 1.5);
    EXPECT_EQ(parse_number("1e-400"), 0.0);
    EXPECT_EQ(parse_number(".5"), 0.5);
    EXPECT_EQ(parse_number("1."), 1.0);
    EXPECT_TRUE(std::isnan(*parse_number("nan")));
    for (const char* bad : {"", "+", "-", "1,5", "1e", "0x10", "1e400", "+-1", "1 "})
        EXPECT_FALSE(parse_number(bad)) << bad;
    EXPECT_EQ(parse_integer("-12"), -12);
    EXPECT_FALSE(parse_integer("1.0"));
    EXPECT_FALSE(parse_integer("99999999999999999999"));
}

TEST(CameraToml, RoundTripIsExact) {
    Numbers n;
    for (LensKind kind : {LensKind::pinhole, LensKind::brown5, LensKind::rational8})
        for (int i = 0; i < 100; ++i) {
            const CameraModel camera = n.camera(kind);
            expect_same(parse_camera(format_camera(camera), "c"), camera);
        }
}

TEST(CameraToml, ReadsTheDocumentedExample) {
    const CameraModel camera = parse_camera(
        "[camera]\nmodel = \"brown5\"\nwidth = 1280\nheight = 1024\nfx = 1500.0\nfy = 1500.0\n"
        "cx = 639.5\ncy = 511.5\ndistortion = [0.0, 0.0, 0.0, 0.0, 0.0]  # as the model asks\n",
        "camera.toml");
    EXPECT_EQ(camera.kind, LensKind::brown5);
    EXPECT_EQ(camera.cx, 639.5);
}

TEST(CameraToml, RefusesWhatIsWrongWithItsPlace) {
    const std::string good =
        "[camera]\nmodel = 'brown5'\nwidth = 10\nheight = 10\nfx = 5\nfy = 5\ncx = 4\ncy = 4\n"
        "distortion = [0, 0, 0, 0, 0]\n";
    const auto with = [&](const std::string& what, const std::string& by) {
        std::string text = good;
        text.replace(text.find(what), what.size(), by);
        return message_of([&] { parse_camera(text, "c.toml"); });
    };
    EXPECT_EQ(with("fx = 5", "fx = 5"), "");
    EXPECT_NE(with("brown5", "brown6").find("line 2: 'model' in [camera]: expected pinhole"),
              std::string::npos);
    EXPECT_NE(with("fx = 5", "fx = -5").find("line 5: "), std::string::npos);
    EXPECT_NE(with("width = 10", "width = 100000000000").find("line 3: "), std::string::npos);
    EXPECT_NE(with("[0, 0, 0, 0, 0]", "[0]").find("5 numbers of brown5, found 1"),
              std::string::npos);
    EXPECT_NE(with("cy = 4\n", "cy = 4\nfocal = 1\n").find("unknown key 'focal'"),
              std::string::npos);
}

TEST(ScannerToml, RoundTripIsExactForEveryMachine) {
    Numbers n;
    for (MachineKind kind : {MachineKind::swept, MachineKind::rail, MachineKind::turntable}) {
        const ScannerModel model = random_model(n, kind);
        const std::string text = format_scanner(model);
        const ScannerModel back = parse_scanner(text, "scanner.toml");
        ASSERT_EQ(back.channels.size(), 2U);
        for (std::size_t i = 0; i < 2; ++i) expect_same(back.channels[i], model.channels[i]);
        EXPECT_EQ(back.covariance, model.covariance);
        EXPECT_EQ(back.volume.min, model.volume.min);
        EXPECT_EQ(back.volume.max, model.volume.max);
        EXPECT_EQ(back.provenance.made_by, model.provenance.made_by);
        EXPECT_EQ(back.provenance.date, model.provenance.date);
        EXPECT_EQ(back.provenance.data_hash, model.provenance.data_hash);
        EXPECT_EQ(back.provenance.rms_px, model.provenance.rms_px);
        EXPECT_EQ(format_scanner(back), text);
    }
}

TEST(ScannerToml, RefusesACovarianceOfOtherParameters) {
    Numbers n;
    const std::string text = format_scanner(random_model(n, MachineKind::rail));
    std::string other = text;
    other.replace(other.find("channel0.camera.fy"), 18, "channel0.camera.fz");
    const std::string message = message_of([&] { parse_scanner(other, "s.toml"); });
    EXPECT_NE(message.find("expected 'channel0.camera.fy' at place 1, found 'channel0.camera.fz'"),
              std::string::npos)
        << message;
}

TEST(ScannerToml, RefusesUnknownKeysInsideAChannel) {
    Numbers n;
    std::string text = format_scanner(random_model(n, MachineKind::swept));
    text.replace(text.find("bow3"), 4, "bov3");
    const std::string message = message_of([&] { parse_scanner(text, "s.toml"); });
    EXPECT_NE(message.find("unknown key 'bov3' in [channel.sheet]: the nearest known key is 'bow"),
              std::string::npos)
        << message;
}

TEST(ScannerToml, NeverCrashesOnATruncatedText) {
    Numbers n;
    ScannerModel model = random_model(n, MachineKind::swept);
    model.channels.resize(1);
    model.covariance.resize(0, 0);
    const std::string text = format_scanner(model);
    for (std::size_t i = 0; i < text.size(); ++i)
        (void)message_of([&] { parse_scanner(text.substr(0, i), "cut"); });
}

TEST(PlanToml, RoundTripIsExact) {
    ScanPlan plan;
    plan.mode = StripeMode::spatial;
    plan.from = -0.1;
    plan.to = 1.0 / 3;
    plan.step = 1e-3 / 7;
    plan.exposures_us = {100.1, 2000};
    plan.laser_power = 0.7;
    plan.lasers = {0, 3};
    plan.off_frames = 2;
    plan.off_exposure_us = 33.3;
    plan.both_directions = true;
    plan.record = RecordWhat::both;
    plan.max_emission_s = 12.5;
    const ScanPlan back = parse_plan(format_plan(plan), "plan.toml");
    EXPECT_EQ(format_plan(back), format_plan(plan));
    EXPECT_EQ(back.from, plan.from);
    EXPECT_EQ(back.to, plan.to);
    EXPECT_EQ(back.step, plan.step);
    EXPECT_EQ(back.exposures_us, plan.exposures_us);
    EXPECT_EQ(back.lasers, plan.lasers);
    EXPECT_EQ(back.record, RecordWhat::both);
    EXPECT_EQ(back.mode, StripeMode::spatial);
    EXPECT_EQ(back.off_exposure_us, plan.off_exposure_us);
    EXPECT_TRUE(back.both_directions);
}

TEST(PlanToml, RefusesWhatCannotBeCarriedOut) {
    EXPECT_NE(message_of([] {
                  parse_plan("from = 1\nto = 0\nstep = 1\n", "p.toml");
              }).find("p.toml: line 2: 'to'"),
              std::string::npos);
    EXPECT_NE(message_of([] {
                  parse_plan("from = 0\nto = 1\nstep = 1\nmode = 'x'\n", "p.toml");
              }).find("expected spatial or spacetime, found 'x'"),
              std::string::npos);
    EXPECT_NE(message_of([] {
                  parse_plan("from = 0\nto = 1\nstep = 1\nlasers = [300]\n", "p");
              }).find("line 4"),
              std::string::npos);
}

}  // namespace
}  // namespace stria
