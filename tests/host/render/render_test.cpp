#include <gtest/gtest.h>

#include <cmath>

#include "host/render/colour_map.h"
#include "host/render/mesh_picture.h"
#include "host/render/plot.h"
#include "host/render/range_picture.h"
#include "host/render/stripe_picture.h"
#include "host/render/svg_axes.h"

namespace stria {
namespace {

TEST(ColourMap, ClampsAndMarksWhatIsNoNumber) {
    const ColourScale scale = {ColourMap::sequential, 0, 10, "x", "mm"};
    EXPECT_EQ(colour_of(scale, -5), colour_of(scale, 0));
    EXPECT_EQ(colour_of(scale, 50), colour_of(scale, 10));
    EXPECT_EQ(colour_of(scale, NAN), Eigen::Vector3f::Constant(0.6f));
}

TEST(ColourMap, SequentialGrowsBrighterAllTheWay) {
    const ColourScale scale = {ColourMap::sequential, 0, 1, "", ""};
    double last = -1;
    for (int i = 0; i <= 64; ++i) {
        const Eigen::Vector3f c = colour_of(scale, i / 64.0);
        const double luma = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];  // Rec. 709
        EXPECT_GT(luma, last) << i;
        last = luma;
    }
}

TEST(ColourMap, SymmetricScaleRoundsUpAndIgnoresNaN) {
    const ColourScale scale = symmetric_scale({-0.03f, 0.01f, NAN, 0.02f}, 1.0, "e", "mm");
    EXPECT_DOUBLE_EQ(scale.high, 0.05);
    EXPECT_DOUBLE_EQ(scale.low, -0.05);
}

/// A square of side 2 at height z, its normal along +z.
void add_square(TriMesh& mesh, double z, double half) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const auto& [x, y] : {std::pair{-half, -half}, {half, -half}, {half, half}, {-half, half}})
        mesh.positions.emplace_back(x, y, z);
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
}

TEST(MeshPicture, ShowsTheNearerSurface) {
    TriMesh mesh;
    add_square(mesh, 0, 1.0);
    add_square(mesh, 1, 0.5);  // nearer to the eye, and smaller
    std::vector<Eigen::Vector3f> colours(4, {1, 0, 0});
    colours.resize(8, {0, 1, 0});
    MeshPictureOptions options;
    options.towards_eye = {0, 0, 1};
    options.up = {0, 1, 0};
    options.width = options.height = 100;
    const ColourImage picture = picture_of_mesh(mesh, colours, options);
    EXPECT_EQ(picture.at(50, 50, 1), 255);  // facing the light: full colour
    EXPECT_EQ(picture.at(50, 50, 0), 0);
    EXPECT_EQ(picture.at(10, 50, 0), 255);
    EXPECT_EQ(picture.at(10, 50, 1), 0);
    EXPECT_EQ(picture.at(0, 0, 2), 255);  // background
}

TEST(MeshPicture, CoversTheAreaOfASphere) {
    TriMesh mesh;
    constexpr int kRings = 60, kSides = 120;
    for (int i = 0; i <= kRings; ++i)
        for (int k = 0; k < kSides; ++k) {
            const double t = M_PI * i / kRings, p = 2 * M_PI * k / kSides;
            mesh.positions.emplace_back(std::sin(t) * std::cos(p), std::sin(t) * std::sin(p),
                                        std::cos(t));
        }
    const auto at = [](int i, int k) {
        return static_cast<std::uint32_t>(i * kSides + k % kSides);
    };
    for (int i = 0; i < kRings; ++i)
        for (int k = 0; k < kSides; ++k) {
            mesh.triangles.push_back({at(i, k), at(i + 1, k), at(i + 1, k + 1)});
            mesh.triangles.push_back({at(i, k), at(i + 1, k + 1), at(i, k + 1)});
        }
    MeshPictureOptions options;
    options.width = options.height = 200;
    options.background = {0, 0, 1};
    const ColourImage picture = picture_of_mesh(mesh, {}, options);
    int covered = 0, red = 0;
    for (int y = 0; y < 200; ++y)
        for (int x = 0; x < 200; ++x) {
            covered += picture.at(x, y, 0) > 0;
            red += picture.at(x, y, 0);
        }
    const double radius = 0.94 * 100;
    EXPECT_NEAR(covered, M_PI * radius * radius, 0.02 * M_PI * radius * radius);  // rim pixels
    EXPECT_GT(red / covered, 100);  // outsides: lit, not the darker insides
}

TEST(MeshPicture, OfNothingIsTheBackground) {
    const ColourImage picture = picture_of_mesh({}, {}, {.width = 8, .height = 8});
    for (const std::uint8_t value : picture.values) EXPECT_EQ(value, 255);
}

TEST(RangePicture, LeavesEmptyCellsWhiteAndReduces) {
    std::vector<float> values(100 * 50, 1.0f);
    std::vector<std::uint8_t> mask(values.size(), 0);
    mask[0] = 1;
    const ColourScale scale = {ColourMap::grey, 0, 2, "", ""};
    const ColourImage picture = picture_of_values(100, 50, values, mask, scale, 50);
    EXPECT_EQ(picture.width, 50);
    EXPECT_EQ(picture.at(0, 0, 0), 128);
    EXPECT_EQ(picture.at(1, 0, 0), 255);
}

TEST(Svg, TicksAreRoundAndInside) {
    for (const auto& [low, high] :
         {std::pair{0.0, 1.0}, {-0.03, 0.041}, {1e-6, 3e-6}, {5.0, 1e5}}) {
        const auto ticks = tick_values({low, high}, 5);
        EXPECT_GE(ticks.size(), 3u);
        EXPECT_LE(ticks.size(), 11u);
        for (const double t : ticks) {
            EXPECT_GE(t, low - 1e-9 * (high - low));
            EXPECT_LE(t, high + 1e-9 * (high - low));
        }
    }
    const auto decades = tick_values({0.02, 300, true}, 5);
    ASSERT_EQ(decades.size(), 4u);  // 0.1, 1, 10, 100
    EXPECT_DOUBLE_EQ(decades[0], 0.1);
}

TEST(Svg, PlotsSurviveWhatCannotBeShown) {
    LinePlot plot;
    plot.y.logarithmic = true;
    plot.series = {{"a & b", {0, 1, NAN, 3}, {-1, 0, 1, 2}}, {"", {}, {}}};
    const std::string svg = line_plot_svg(plot);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
    EXPECT_NE(svg.find("a &amp; b"), std::string::npos);
    EXPECT_EQ(histogram_svg({}).find("nan"), std::string::npos);
    plot.series = {{"", {1}, {}}};
    EXPECT_THROW(line_plot_svg(plot), std::invalid_argument);
}

TEST(StripePicture, MarksAPeakWhereItIs) {
    Frame frame;
    resize(frame, 20, 10, 8);
    Pulse peak;
    peak.u = 12;
    peak.v = 4;
    const ColourImage upright = picture_of_peaks(frame, {peak});
    EXPECT_EQ(upright.at(12 * 3 + 1, 4 * 3 + 1, 1), 255);
    EXPECT_EQ(upright.at(12 * 3, 4 * 3 + 1, 1), 255);  // arm of the cross
    EXPECT_EQ(upright.at(12 * 3, 4 * 3, 1), 0);
    EXPECT_EQ(upright.at(12 * 3 - 1, 4 * 3 + 1, 1), 0);
    const ColourImage turned = picture_of_peaks(frame, {peak}, true);
    EXPECT_EQ(turned.width, 30);
    EXPECT_EQ(turned.at(4 * 3 + 1, 12 * 3 + 1, 1), 255);
}

}  // namespace
}  // namespace stria
