#include "firmware/core/scan_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace stria {
namespace {

ScanPlan good() {
    ScanPlan plan;
    plan.from = -0.2;
    plan.to = 0.2;
    plan.step = 0.001;
    return plan;
}

TEST(ScanPlan, AcceptsAUsualOne) { EXPECT_EQ(validate(good()), ""); }

TEST(ScanPlan, NamesTheFieldThatIsWrong) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto field = [](auto change) {
        ScanPlan plan = good();
        change(plan);
        const std::string why = validate(plan);
        return why.substr(0, why.find(' '));
    };
    EXPECT_EQ(field([&](ScanPlan& p) { p.from = nan; }), "from");
    EXPECT_EQ(field([&](ScanPlan& p) { p.to = nan; }), "to");
    EXPECT_EQ(field([](ScanPlan& p) { p.to = p.from; }), "to");
    EXPECT_EQ(field([](ScanPlan& p) { p.step = 0; }), "step");
    EXPECT_EQ(field([](ScanPlan& p) { p.step = -1; }), "step");
    EXPECT_EQ(field([&](ScanPlan& p) { p.step = nan; }), "step");
    EXPECT_EQ(field([](ScanPlan& p) { p.step = 1e-7; }), "step");  // 4 million frames
    EXPECT_EQ(field([](ScanPlan& p) { p.exposures_us = {100, 0}; }), "exposures_us");
    EXPECT_EQ(field([](ScanPlan& p) { p.exposures_us.assign(9, 100.0); }), "exposures_us");
    EXPECT_EQ(field([](ScanPlan& p) { p.laser_power = 0; }), "laser_power");
    EXPECT_EQ(field([](ScanPlan& p) { p.laser_power = 1.1; }), "laser_power");
    EXPECT_EQ(field([](ScanPlan& p) { p.lasers.clear(); }), "lasers");
    EXPECT_EQ(field([](ScanPlan& p) { p.off_frames = -1; }), "off_frames");
    EXPECT_EQ(field([](ScanPlan& p) { p.off_exposure_us = -1; }), "off_exposure_us");
    EXPECT_EQ(field([&](ScanPlan& p) { p.max_emission_s = nan; }), "max_emission_s");
    EXPECT_EQ(field([](ScanPlan& p) { p.max_emission_s = 4000; }), "max_emission_s");
}

}  // namespace
}  // namespace stria
