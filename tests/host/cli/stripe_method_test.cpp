#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "firmware/stripe/peak_methods.h"
#include "host/cli/run.h"
#include "host/core/frame_image.h"
#include "host/io/image_io.h"
#include "host/io/whole_file.h"
#include "tests/firmware/stripe/row_frames.h"
#include "tests/host/io/temporary_folder.h"

/// `stria stripe --method` on a straight stripe of known place.
namespace stria {
namespace {

constexpr double kAt = 40.3, kWidthPx = 1.5;

int stria(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv = {"stria"};
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    return run_program(static_cast<int>(argv.size()), argv.data());
}

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
