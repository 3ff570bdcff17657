#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "host/cli/run.h"
#include "host/io/mesh_io.h"
#include "host/io/range_io.h"
#include "host/io/whole_file.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

int run(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv = {"stria"};
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    return run_program(static_cast<int>(argv.size()), argv.data());
}

int convert(const std::string& in, const std::string& out, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {"mesh", "convert", in, "--out", out, "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
}

TEST(MeshConvert, KeepsTheMeshThroughEveryFormat) {
    const TemporaryFolder folder;
    write_whole_file(folder / "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\n");
    std::string last = folder / "a.obj";
    for (const char* name : {"b.ply", "c.off", "d.stl", "e.obj"}) {
        ASSERT_EQ(convert(last, folder / name), 0) << name;
        last = folder / name;
        const TriMesh mesh = read_mesh(last);
        EXPECT_EQ(mesh.positions.size(), 4U) << name;
        EXPECT_EQ(mesh.triangles.size(), 2U) << name;
    }
    ASSERT_EQ(convert(last, folder / "f.glb"), 0);
    EXPECT_EQ(read_whole_file(folder / "f.glb").substr(0, 4), "glTF");
    ASSERT_EQ(convert(last, folder / "g.xyz"), 0);
    EXPECT_EQ(read_points(folder / "g.xyz").positions.size(), 4U);
}

TEST(MeshConvert, TriangulatesARangeImage) {
    const TemporaryFolder folder;
    RangeImage image = make_range_image(3, 3);
    for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 3; ++x) {
            if (x == 2 && y == 2) continue;
            image.mask[image.cell(x, y)] = 1;
            image.points[image.cell(x, y)].position = {1.0 * x, -1.0 * y, 0};
            image.points[image.cell(x, y)].sigma_mm = 0.02F;
        }
    write_range_image(folder / "range.ply", image);
    ASSERT_EQ(convert(folder / "range.ply", folder / "mesh.ply"), 0);
    const TriMesh mesh = read_mesh(folder / "mesh.ply");
    EXPECT_EQ(mesh.positions.size(), 8U);
    EXPECT_EQ(mesh.triangles.size(), 7U);  // three quads and one half
    ASSERT_NE(mesh.find_attribute("sigma"), nullptr);
    EXPECT_EQ(mesh.find_attribute("sigma")->values[0], 0.02F);
    for (const auto& t : mesh.triangles) {  // towards the camera, which looks along -z
        const Eigen::Vector3d a = mesh.positions[t[1]] - mesh.positions[t[0]];
        const Eigen::Vector3d b = mesh.positions[t[2]] - mesh.positions[t[0]];
        EXPECT_GT(a.x() * b.y() - a.y() * b.x(), 0);
    }
}

TEST(MeshConvert, ScalesByTheUnitAndKeepsOutputs) {
    const TemporaryFolder folder;
    write_whole_file(folder / "a.xyz", "1 2 3\n4 5 6\n");
    ASSERT_EQ(convert(folder / "a.xyz", folder / "b.ply", {"--unit", "in"}), 0);
    EXPECT_EQ(read_points(folder / "b.ply").positions.at(0).x(), static_cast<double>(25.4F));
    EXPECT_EQ(convert(folder / "a.xyz", folder / "b.ply"), 1);  // exists
    EXPECT_EQ(convert(folder / "a.xyz", folder / "b.ply", {"--force"}), 0);
    EXPECT_EQ(read_points(folder / "b.ply").positions.at(0).x(), 1.0);
}

TEST(MeshConvert, FailsWithAReasonAndLeavesNothing) {
    const TemporaryFolder folder;
    write_whole_file(folder / "a.xyz", "1 2 3\n");
    EXPECT_EQ(convert(folder / "a.xyz", folder / "b.stl"), 1);
    EXPECT_EQ(convert(folder / "none.ply", folder / "b.ply"), 1);
    EXPECT_EQ(convert(folder / "a.xyz", folder / "b.doc"), 1);
    EXPECT_EQ(run({"mesh", "convert", folder / "a.xyz"}), 2);
    EXPECT_THROW(read_whole_file(folder / "b.stl"), std::exception);
}

}  // namespace
}  // namespace stria
