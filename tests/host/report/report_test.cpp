#include "host/report/report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "host/render/plot.h"
#include "host/render/range_picture.h"
#include "host/report/base64.h"

namespace stria {
namespace {

TriMesh wavy_sheet(int side) {
    TriMesh mesh;
    VertexAttribute error{"error", 1, {}};
    for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
            const double a = 100.0 * x / side - 50, b = 100.0 * y / side - 50;
            mesh.positions.emplace_back(a, b, 12.0 * std::sin(0.1 * a) * std::cos(0.08 * b));
            error.values.push_back(static_cast<float>(0.03 * std::sin(0.2 * a + 0.1 * b)));
        }
    }
    const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * side + x); };
    for (int y = 0; y + 1 < side; ++y) {
        for (int x = 0; x + 1 < side; ++x) {
            mesh.triangles.push_back({at(x, y), at(x + 1, y), at(x, y + 1)});
            mesh.triangles.push_back({at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
        }
    }
    mesh.attributes.push_back(error);
    return mesh;
}

Report sample_report() {
    Report report;
    report.title = "Scan of a <wavy> sheet & its error";
    report.subtitle = "8 scans, 0.3 mm voxels";
    report.summary = {{"overall rms error", "0.031", "mm", "<= 0.05", true},
                      {"sigma ratio", "1.31", "", "0.8 to 1.25", false},
                      {"peak memory", "412", "MB", "", std::nullopt}};
    const TriMesh mesh = wavy_sheet(60);
    const ColourScale scale =
        symmetric_scale(mesh.attributes[0].values, 0.98, "signed error", "mm");
    ReportMesh viewer;
    viewer.caption = "Error on the mesh.";
    viewer.mesh = mesh;
    viewer.colours = vertex_colours(mesh, "error", scale);
    viewer.scale = scale;
    report.sections.push_back({"Mesh", {ReportText{"First part.\n\nSecond part."}, viewer}});

    std::mt19937 rng(3);
    std::normal_distribution<double> normal(0.0, 0.03);
    Histogram histogram;
    histogram.x = {"error", "mm"};
    for (int i = 0; i < 20000; ++i) histogram.values.push_back(normal(rng));
    histogram.low = -0.1;
    histogram.high = 0.1;
    histogram.normal_sigma = 0.03;
    LinePlot plot;
    plot.x = {"iteration", ""};
    plot.y = {"overlap rms", "mm", true};
    plot.series = {{"measured", {1, 2, 3, 4, 5, 6}, {2.0, 0.6, 0.2, 0.07, 0.041, 0.04}},
                   {"expected", {1, 6}, {0.04, 0.04}, true}};
    report.sections.push_back({"Convergence and noise",
                               {ReportDrawing{"Joint registration.", line_plot_svg(plot)},
                                ReportDrawing{"Error of the points.", histogram_svg(histogram)}}});

    std::vector<float> values(300 * 200);
    std::vector<std::uint8_t> mask(values.size(), 1);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 300);
    const ColourScale depth = {ColourMap::sequential, 0, 300, "depth", "mm"};
    ReportPictures pictures;
    pictures.pictures = {{"Scan 1", picture_of_values(300, 200, values, mask, depth)},
                         {"Scan 2", picture_of_values(300, 200, values, mask, depth)}};
    pictures.scale = depth;
    ReportTable table{"Time and memory.",
                      {"stage", "seconds", "peak (MB)"},
                      {{"register", "4.1", "210"}, {"fuse", "11.9", "402"}}};
    report.sections.push_back({"Scans", {pictures, table}});
    return report;
}

TEST(Report, NeedsNoOtherFile) {
    const std::string page = to_html(sample_report());
    EXPECT_EQ(page.find("src='http"), std::string::npos);
    EXPECT_EQ(page.find("<link"), std::string::npos);
    EXPECT_EQ(page.find("@import"), std::string::npos);
    EXPECT_EQ(page.find("fetch("), std::string::npos);
}

TEST(Report, EscapesTextAndParagraphs) {
    const std::string page = to_html(sample_report());
    EXPECT_NE(page.find("Scan of a &lt;wavy&gt; sheet &amp; its error"), std::string::npos);
    EXPECT_EQ(page.find("<wavy>"), std::string::npos);
    EXPECT_NE(page.find("<p>First part.</p>"), std::string::npos);
    EXPECT_NE(page.find("<p>Second part.</p>"), std::string::npos);
}

TEST(Report, SaysWhichFiguresKeepTheirLimits) {
    const std::string page = to_html(sample_report());
    EXPECT_NE(page.find(">kept<"), std::string::npos);
    EXPECT_NE(page.find(">missed<"), std::string::npos);
}

TEST(Report, IsTheSameTwice) { EXPECT_EQ(to_html(sample_report()), to_html(sample_report())); }

TEST(Report, RefusesTablesAndColoursThatDoNotFit) {
    Report report;
    report.sections = {{"", {ReportTable{"t", {"a", "b"}, {{"1"}}}}}};
    EXPECT_THROW(to_html(report), std::invalid_argument);
    ReportMesh mesh;
    mesh.mesh = wavy_sheet(3);
    mesh.colours.resize(2);
    report.sections = {{"", {mesh}}};
    EXPECT_THROW(to_html(report), std::invalid_argument);
}

TEST(Report, WritesThePageWhereAskedTo) {
    // Set STRIA_REPORT_OUT to look at the page in a browser.
    const char* out = std::getenv("STRIA_REPORT_OUT");
    const std::string path = out ? out : testing::TempDir() + "stria_report.html";
    write_report(path, sample_report());
}

TEST(Base64, MatchesTheExamplesOfRfc4648) {
    EXPECT_EQ(to_base64(""), "");
    EXPECT_EQ(to_base64("f"), "Zg==");
    EXPECT_EQ(to_base64("fo"), "Zm8=");
    EXPECT_EQ(to_base64("foo"), "Zm9v");
    EXPECT_EQ(to_base64("foob"), "Zm9vYg==");
    EXPECT_EQ(to_base64("fooba"), "Zm9vYmE=");
    EXPECT_EQ(to_base64("foobar"), "Zm9vYmFy");
}

TEST(FormatNumber, KeepsSignificantDigits) {
    EXPECT_EQ(format_number(0.03142), "0.0314");
    EXPECT_EQ(format_number(3.14159), "3.14");
    EXPECT_EQ(format_number(412.4), "412");
    EXPECT_EQ(format_number(0), "0.00");
    EXPECT_EQ(format_number(1.5e-6), "1.50e-06");
    EXPECT_EQ(format_number(NAN), "-");
}

}  // namespace
}  // namespace stria
