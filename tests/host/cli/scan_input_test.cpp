#include "host/cli/scan_input.h"

#include <gtest/gtest.h>

#include "host/core/errors.h"
#include "host/io/mesh_io.h"
#include "host/io/range_io.h"
#include "host/io/whole_file.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

/// Two points that far apart.
RangeImage pair_of_points(double distance_mm) {
    RangeImage image = make_range_image(2, 1);
    image.mask = {1, 1};
    image.points[1].position.x() = distance_mm;
    return image;
}

std::string refusal(const std::vector<std::string>& arguments, const std::string& unit = "") {
    Context context;
    context.quiet = true;
    context.unit = unit;
    return message_of([&] { read_range_scans(arguments, context); });
}

TEST(ScanInput, ReadsAProjectsScansInOrder) {
    const TemporaryFolder folder;
    const Project project = create_project(folder / "part");
    for (const double distance : {10.0, 20.0})
        write_range_image(make_next_scan(project).range(), pair_of_points(distance));
    Context context;
    context.quiet = true;
    const auto inputs = read_range_scans({folder / "part"}, context);
    ASSERT_EQ(inputs.size(), 2U);
    EXPECT_EQ(inputs[1].image.points[1].position.x(), 20);
    EXPECT_EQ(inputs[1].source.range, folder / "part/scans/0002/range.ply");
}

TEST(ScanInput, AsksForTheUnitWhereMillimetresCannotBe) {
    const TemporaryFolder folder;
    write_range_image(folder / "metres.ply", pair_of_points(0.15));
    EXPECT_NE(refusal({folder / "metres.ply"}).find("span 0.15 mm, expected at least 2"),
              std::string::npos);
    EXPECT_EQ(refusal({folder / "metres.ply"}, "m"), "");
    EXPECT_EQ(refusal({folder / "metres.ply"}, "mm"), "");  // its owner knows better
    write_range_image(folder / "um.ply", pair_of_points(1e5));
    EXPECT_NE(refusal({folder / "um.ply"}).find("--unit um"), std::string::npos);
}

TEST(ScanInput, SaysWhatAScanLacks) {
    const TemporaryFolder folder;
    write_range_image(folder / "empty.ply", make_range_image(3, 3));
    EXPECT_NE(refusal({folder / "empty.ply"}).find("found none in its grid"), std::string::npos);
    write_whole_file(folder / "a.xyz", "1 2 3\n");
    EXPECT_NE(refusal({folder / "a.xyz"}).find("points without a grid"), std::string::npos);
    write_whole_file(folder / "a.stria", "");
    EXPECT_NE(refusal({folder / "a.stria"}).find("stria range"), std::string::npos);
    EXPECT_NE(refusal({folder / "none"}).find("no such file"), std::string::npos);
}

}  // namespace
}  // namespace stria
