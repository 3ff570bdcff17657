#include "host/verify/artefact.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stria {
namespace {

TEST(Artefact, ExpandsWithTemperature) {
    Artefact artefact;
    const CalibratedLength metre = {1000, 0.001};
    EXPECT_EQ(at_temperature(artefact, metre).mm, 1000);  // nothing stated, nothing corrected
    artefact.temperature = Temperature{.reference_c = 20,
                                       .measured_c = 23,
                                       .measured_expanded_c = 0.5,
                                       .cte_per_k = 11.5e-6,
                                       .cte_expanded_per_k = 1e-6};
    const CalibratedLength warm = at_temperature(artefact, metre);
    EXPECT_NEAR(warm.mm, 1000.0345, 1e-9);  // 34.5 um for 3 K of steel
    // 1 um, 1000 x 11.5e-6 x 0.5 = 5.75 um, 1000 x 3 x 1e-6 = 3 um
    EXPECT_NEAR(warm.expanded_mm, std::sqrt(1e-6 + 33.0625e-6 + 9e-6), 1e-9);
}

TEST(Artefact, IsAcceptedOnlyForCertain) {
    EXPECT_EQ(judge(0.010, 0.004, {}), Verdict::not_asked);
    EXPECT_EQ(judge(-0.010, 0.004, 0.014), Verdict::accepted);
    EXPECT_EQ(judge(-0.0101, 0.004, 0.014), Verdict::undecided);
    EXPECT_EQ(judge(0.0179, 0.004, 0.014), Verdict::undecided);
    EXPECT_EQ(judge(0.0181, 0.004, 0.014), Verdict::rejected);
}

TEST(Artefact, RefusesWhatMakesNoSense) {
    Artefact artefact;
    artefact.diameters = {{25, 0.001}};
    EXPECT_EQ(validate(artefact), "");
    Artefact wrong = artefact;
    wrong.diameters[0].mm = -25;
    EXPECT_NE(validate(wrong).find("diameter"), std::string::npos);
    wrong = artefact;
    wrong.diameters[0].expanded_mm = 1;
    EXPECT_NE(validate(wrong).find("uncertainty"), std::string::npos);
    wrong = artefact;
    wrong.temperature = Temperature{.cte_per_k = 11.5};
    EXPECT_NE(validate(wrong).find("cte_per_k"), std::string::npos);
    wrong = artefact;
    wrong.mpe_form_mm = 0.0;
    EXPECT_NE(validate(wrong).find("maximum permissible"), std::string::npos);
}

}  // namespace
}  // namespace stria
