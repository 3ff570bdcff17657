#include "host/advise/design.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "host/core/errors.h"

namespace stria {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(Design, OfEveryKindGetsAWholeAdvice) {
    for (const MachineKind kind : {MachineKind::swept, MachineKind::rail, MachineKind::turntable}) {
        ScannerDesign design;
        design.kind = kind;
        const DesignAdvice made = advise_design(design);
        EXPECT_NEAR(made.advice.middle.crossing.triangulation_rad, 25 * M_PI / 180, 1e-6)
            << name_of(kind);
        EXPECT_NEAR(made.advice.field_width_mm, 200, 1e-9);
        EXPECT_TRUE(made.baseline_chosen);
        EXPECT_GT(made.advice.worst_z_mm(), 0);
        EXPECT_TRUE(std::isfinite(made.advice.worst_z_mm())) << name_of(kind);
        EXPECT_GT(made.advice.frames, 10);
        EXPECT_TRUE(made.advice.warnings.empty()) << made.advice.warnings.front();
        EXPECT_GT(made.advice.worst.snr, 10) << "a corner is not lit";
        EXPECT_LT(made.advice.method(made.advice.worst).z_mm, 2 * made.advice.worst_z_mm());
    }
}

TEST(Design, ItsSheetCrossesTheCamerasAxisAtTheDistance) {
    std::mt19937 rng(4);
    std::uniform_real_distribution<double> u(0, 1);
    for (int i = 0; i < 100; ++i) {
        ScannerDesign design;
        design.kind = static_cast<MachineKind>(i % 3);
        design.distance_mm = 100 + 1000 * u(rng);
        design.depth_mm = 0.3 * design.distance_mm;
        design.width_mm = 0.5 * design.distance_mm;
        const AdvisedScanner scanner = scanner_of(design, design.distance_mm * (0.2 + u(rng)));
        const LaserSheet sheet = sheet_at(scanner.channel, 0);
        EXPECT_NEAR(signed_distance(sheet, {0, 0, design.distance_mm}), 0,
                    1e-9 * design.distance_mm)
            << i;
        EXPECT_EQ(validate(scanner), "") << i;
    }
}

TEST(Design, BaselineForAWantedSigmaGivesThatSigma) {
    std::mt19937 rng(6);
    std::uniform_real_distribution<double> u(0, 1);
    int reached = 0;
    for (int i = 0; i < 20; ++i) {
        ScannerDesign design;
        design.surface.speckle_contrast = 0.2 + 0.5 * u(rng);
        design.distance_mm = 300 + 300 * u(rng);
        design.depth_mm = 60;
        design.sigma_z_mm = 0.03 + 0.1 * u(rng);
        const DesignAdvice made = advise_design(design);
        if (!made.baseline_for_sigma_mm) {
            EXPECT_GT(made.best_sigma_z_mm, *design.sigma_z_mm) << i;
            continue;
        }
        ++reached;
        EXPECT_NEAR(made.advice.worst_z_mm(), *design.sigma_z_mm, 1e-5 * *design.sigma_z_mm) << i;
        // The reverse: that baseline, stated, gives that sigma.
        ScannerDesign reverse = design;
        reverse.sigma_z_mm.reset();
        reverse.baseline_mm = made.baseline_for_sigma_mm;
        EXPECT_NEAR(advise_design(reverse).advice.worst_z_mm(), made.advice.worst_z_mm(), 1e-12);
    }
    EXPECT_GE(reached, 5);
}

TEST(Design, SaysThatASigmaCannotBeHad) {
    ScannerDesign design;
    design.sigma_z_mm = 1e-6;
    const DesignAdvice made = advise_design(design);
    EXPECT_FALSE(made.baseline_for_sigma_mm);
    EXPECT_GT(made.best_sigma_z_mm, 1e-6);
}

TEST(Design, WiderBaselinesMeasureDepthBetterAndSeeLess) {
    double last_z = 1e300, last_share = 2;
    for (const double baseline : {60.0, 100.0, 160.0, 250.0, 400.0}) {
        ScannerDesign design;
        design.baseline_mm = baseline;
        const Advice advice = advise_design(design).advice;
        EXPECT_LT(advice.middle.spacetime.z_mm, last_z) << baseline;
        EXPECT_LT(advice.occlusion.hemisphere_share, last_share) << baseline;
        last_z = advice.middle.spacetime.z_mm;
        last_share = advice.occlusion.hemisphere_share;
    }
}

TEST(Design, ChoosesAStripeFourFootprintsWide) {
    const DesignAdvice made = advise_design({});
    const DepthAdvice& far = made.advice.far;
    EXPECT_NEAR(made.advice.middle.sigma_b_mm / far.footprint.sigma_mm(), 4, 0.05);
    ScannerDesign stated;
    stated.waist_sigma_mm = 0.3;
    EXPECT_EQ(advise_design(stated).scanner.channel.sheet.waist_sigma_mm, 0.3);
}

TEST(Design, NamesWhatIsWrongWithIt) {
    const struct {
        const char* name;
        void (*spoil)(ScannerDesign&);
    } cases[] = {
        {"width_mm", [](ScannerDesign& d) { d.width_mm = 0; }},
        {"distance_mm", [](ScannerDesign& d) { d.distance_mm = kNaN; }},
        {"distance_mm", [](ScannerDesign& d) { d.distance_mm = -4; }},
        {"depth_mm", [](ScannerDesign& d) { d.depth_mm = 2 * d.distance_mm; }},
        {"depth_mm", [](ScannerDesign& d) { d.depth_mm = -1; }},
        {"width_px", [](ScannerDesign& d) { d.width_px = 0; }},
        {"height_px", [](ScannerDesign& d) { d.height_px = -3; }},
        {"wavelength_nm", [](ScannerDesign& d) { d.wavelength_nm = 0.65; }},
        {"power_mw", [](ScannerDesign& d) { d.power_mw = -1; }},
        {"m_squared", [](ScannerDesign& d) { d.m_squared = 0; }},
        {"waist_sigma_mm", [](ScannerDesign& d) { d.waist_sigma_mm = 0; }},
        {"waist_at_mm", [](ScannerDesign& d) { d.waist_at_mm = kNaN; }},
        {"fan_rad", [](ScannerDesign& d) { d.fan_rad = 0; }},
        {"laser_to_mirror_mm", [](ScannerDesign& d) { d.laser_to_mirror_mm = 0; }},
        {"baseline_mm", [](ScannerDesign& d) { d.baseline_mm = 0; }},
        {"sigma_z_mm", [](ScannerDesign& d) { d.sigma_z_mm = kNaN; }},
        {"step", [](ScannerDesign& d) { d.step = 0; }},
        {"axis_sigma", [](ScannerDesign& d) { d.axis_sigma = -1; }},
        {"albedo", [](ScannerDesign& d) { d.surface.albedo = 1.2; }},
        {"f_number", [](ScannerDesign& d) { d.sensor.f_number = 0; }},
    };
    for (const auto& c : cases) {
        ScannerDesign design;
        c.spoil(design);
        EXPECT_EQ(validate(design).rfind(c.name, 0), 0U) << c.name << ": " << validate(design);
        EXPECT_THROW(advise_design(design), std::invalid_argument) << c.name;
    }
    EXPECT_THROW(named_camera("kodak"), std::invalid_argument);
    EXPECT_EQ(named_camera("imx296").width, 1456);
}

}  // namespace
}  // namespace stria
