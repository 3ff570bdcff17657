#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <random>
#include <set>

#include "host/core/errors.h"
#include "host/io/mesh_io.h"
#include "host/io/whole_file.h"
#include "tests/host/io/guarded_run.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

namespace fs = std::filesystem;

std::string data_folder() {
    const char* data = std::getenv("STRIA_TEST_DATA");
    return data ? data : "";
}

/// What the files must say: a part of the description or of the refusal. Counts from their authors
/// (README beside them) or by eye.
const std::map<std::string, std::string> kExpected = {
    {"assimp__OutOfMemory.off", "at most what the file's"},
    {"assimp__Spider_ascii.stl", "1368 triangles"},
    {"assimp__Spider_binary.stl", "1368 triangles"},
    {"assimp__box_UTF16BE.obj", "found UTF-16"},
    {"assimp__crash-30d6d0f7c529b3b66b4131700b7a4580cd7082df.ply", "line 7: expected a type"},
    {"assimp__cube_binary.ply", "8 vertices, 12 triangles"},
    {"assimp__cube_binary_header_with_RN_newline.ply", "8 vertices, 12 triangles"},
    {"assimp__cube_uv.ply", "24 vertices, 12 triangles"},
    {"assimp__invalid.off", "line 7: "},
    {"assimp__issue623.ply", "element vertex, row 0 of 24"},
    {"assimp__malformed2.obj", "line 23: "},
    {"assimp__triangle_with_two_solids.stl", "2 triangles"},
    {"trimesh__busted.STL", "1941 vertices, 3878 triangles"},
    {"trimesh__cube.OBJ", "8 vertices, 12 triangles"},
    {"trimesh__emptyIO_ply_empty_header.ply", "expected an element vertex"},
    {"trimesh__emptyIO_stl_empty_bin.stl", "0 vertices, 0 triangles"},
    {"trimesh__negative_indices.obj", "8 vertices, 12 triangles"},
    {"trimesh__notenoughindices.obj", "line 9: expected a face of at least 3 corners"},
    {"trimesh__points_emptyface.ply", "1024 vertices, 0 triangles"},
    {"trimesh__soup.stl", "100 triangles"},
    {"trimesh__two_objects_mixed_case_names.stl", "24 triangles"},
    {"trimesh__whitespace.off", "8 vertices, 12 triangles"},
};

TEST(BadInput, EveryFileIsReadOrRefusedInTimeAndMemory) {
    if (data_folder().empty())
        GTEST_SKIP() << "set STRIA_TEST_DATA to the folder of real data sets";
    std::size_t files = 0;
    for (const auto& entry : fs::directory_iterator(data_folder() + "/bad_input")) {
        const std::string path = entry.path().string();
        if (entry.path().extension() == ".md") continue;
        ++files;
        const GuardedResult result = run_guarded([&] { return describe_file(path); });
        EXPECT_FALSE(result.crashed) << path << ": " << result.message;
        EXPECT_LT(result.seconds, 2.0) << path;
        EXPECT_TRUE(!kPeakIsOurs || result.peak_mb < 200.0)
            << path << ": " << result.peak_mb << " MB";
        if (result.refused) {
            EXPECT_EQ(result.message.find(path + ": "), 0U) << result.message;
        }
        const auto expected = kExpected.find(entry.path().filename().string());
        if (expected != kExpected.end()) {
            EXPECT_NE(result.message.find(expected->second), std::string::npos)
                << path << ": " << result.message;
        }
    }
    EXPECT_GE(files, kExpected.size());
}

TEST(BadInput, TruncationsOfEveryFileAreReadOrRefused) {
    if (data_folder().empty())
        GTEST_SKIP() << "set STRIA_TEST_DATA to the folder of real data sets";
    for (const auto& entry : fs::directory_iterator(data_folder() + "/bad_input")) {
        if (entry.path().extension() == ".md") continue;
        const std::string path = entry.path().string();
        const std::string bytes = read_whole_file(path);
        // Up to 4 kB at every byte, larger ones at 1000 seeded places.
        std::vector<std::size_t> places;
        std::mt19937 rng(17);
        for (std::size_t n = 0; bytes.size() <= 4096 && n < bytes.size(); ++n) places.push_back(n);
        while (bytes.size() > 4096 && places.size() < 1000) places.push_back(rng() % bytes.size());
        const GuardedResult result = run_guarded(
            [&] {
                std::size_t refused = 0;
                for (const std::size_t n : places) try {
                        (void)parse_mesh(std::string_view(bytes).substr(0, n), path);
                    } catch (const Error&) {
                        ++refused;
                    }
                return std::to_string(refused) + " refused";
            },
            60.0);
        EXPECT_FALSE(result.crashed) << path << ": " << result.message;
        EXPECT_TRUE(!kPeakIsOurs || result.peak_mb < 200.0)
            << path << ": " << result.peak_mb << " MB";
    }
}

struct Topology {
    std::size_t vertices, triangles;
    long euler;
};

/// V - E + F over referenced vertices.
long euler_number(const TriMesh& mesh) {
    std::set<std::uint32_t> vertices;
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (const auto& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            vertices.insert(t[k]);
            edges.insert(std::minmax(t[k], t[(k + 1) % 3]));
        }
    return static_cast<long>(vertices.size()) - static_cast<long>(edges.size()) +
           static_cast<long>(mesh.triangles.size());
}

TEST(KnownMeshes, HaveTheirKnownTopology) {
    if (data_folder().empty())
        GTEST_SKIP() << "set STRIA_TEST_DATA to the folder of real data sets";
    const std::map<std::string, Topology> known = {
        {"meshes/fandisk.obj", {6475, 12946, 2}},
        {"meshes/rocker-arm.obj", {10044, 20088, 0}},
        {"meshes/homer.obj", {6002, 12000, 2}},
        {"meshes/spot.obj", {2930, 5856, 2}},
        {"meshes/cow.obj", {2903, 5804, 1}},
        {"meshes/teapot.obj", {3644, 6320, -34}},
        {"meshes/cycloidal.ply", {21384, 43368, -58}},
        {"meshes/featuretype.STL", {2010, 3476, -16}},
        {"stanford_bunny/bun_zipper.ply", {35947, 69451, -3}}};
    for (const auto& [file, topology] : known) {
        const TriMesh mesh = read_mesh(data_folder() + "/" + file);
        EXPECT_EQ(mesh.positions.size(), topology.vertices) << file;
        EXPECT_EQ(mesh.triangles.size(), topology.triangles) << file;
        EXPECT_EQ(euler_number(mesh), topology.euler) << file;
    }
}

TEST(KnownClouds, HaveTheirKnownSize) {
    if (data_folder().empty())
        GTEST_SKIP() << "set STRIA_TEST_DATA to the folder of real data sets";
    const auto read = [](const std::string& file) {
        return read_points(data_folder() + "/" + file);
    };
    EXPECT_EQ(read("icp_bunny_pcd/bun0.pcd").positions.size(), 397U);
    EXPECT_EQ(read("icp_bunny_pcd/noisy_slice_displaced.pcd").positions.size(), 3782U);
    EXPECT_EQ(read("icp_bunny_pcd/sac_plane_test.pcd").positions.size(), 3283U);
    const PointCloud car = read("icp_car_clouds/car_cloud400.csv");
    EXPECT_EQ(car.positions.at(0), Eigen::Vector3d(-3.5376, 0.639553, -1.37678));
    EXPECT_EQ(car.attributes.at(0).name, "normal");
}

/// The kinds of damage that the data set shows, made here so that they are tested without it.
TEST(MalformedFiles, AreRefusedWithinTimeAndMemory) {
    const std::string ply = "ply\nformat binary_little_endian 1.0\n";
    const std::map<std::string, std::pair<std::string, std::string>> files = {
        {"count.ply",
         {ply + "element vertex 4294967295\nproperty float x\nend_header\n",
          "more rows than the file holds"}},
        {"list.ply",
         {ply + "element vertex 1\nproperty list uint double x\nend_header\n" +
              std::string("\xFF\xFF\xFF\x7F", 4) + std::string(64, 'x'),
          "more than the file holds"}},
        {"empty.ply", {"", "found an empty file"}},
        {"cr.ply", {"ply\rformat ascii 1.0\rend_header\r", "expected an element vertex"}},
        {"count.off", {"OFF\n4000000000 4000000000 0\n", "number of vertices"}},
        {"count.stl", {std::string(80, 'x') + "\xFF\xFF\xFF\xFF", "expected 214748364834 bytes"}},
        {"wide.obj", {std::string("\0v\0 \0", 5), "UTF-16"}},
        {"corner.obj", {"v 0 0 0\nf 1 1 99999999999999999999\n", "index of a vertex"}},
        {"count.pcd",
         {"FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4294967295\n"
          "HEIGHT 1\nPOINTS 4294967295\nDATA binary\n12345678",
          "expected 4294967295 points"}},
        {"wide.pcd",
         {"FIELDS x\nSIZE 8\nTYPE F\nCOUNT 4096\nWIDTH 4294967296\nHEIGHT 4294967296\n"
          "DATA binary_compressed\n" +
              std::string(8, '\xFF'),
          "compressed bytes"}},
    };
    const TemporaryFolder folder;
    for (const auto& [name, content] : files) {
        write_whole_file(folder / name, content.first);
        const GuardedResult result =
            run_guarded([&path = name, &folder] { return describe_file(folder / path); });
        EXPECT_FALSE(result.crashed) << name << ": " << result.message;
        EXPECT_TRUE(result.refused) << name << ": " << result.message;
        EXPECT_NE(result.message.find(content.second), std::string::npos) << result.message;
        EXPECT_LT(result.seconds, 2.0) << name;
        EXPECT_TRUE(!kPeakIsOurs || result.peak_mb < 200.0)
            << name << ": " << result.peak_mb << " MB";
    }
}

TEST(MalformedFiles, SurviveFlippedAndRepeatedBytes) {
    const TemporaryFolder folder;
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    std::mt19937 rng(23);
    for (const std::string name : {"a.ply", "a.obj", "a.stl", "a.off"}) {
        write_mesh(folder / name, mesh);
        const std::string whole = read_whole_file(folder / name);
        for (int i = 0; i < 3000; ++i) {
            std::string bytes = whole;
            for (int k = 0; k < 3; ++k) bytes[rng() % bytes.size()] = static_cast<char>(rng());
            const std::size_t at = rng() % bytes.size();
            if (i % 3 == 0) bytes.insert(at, bytes.substr(at, rng() % 20));
            (void)message_of([&] { parse_mesh(bytes, name); });  // any answer, no crash
        }
    }
}

}  // namespace
}  // namespace stria
