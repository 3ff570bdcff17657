#include "host/io/mesh_io.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>

#include "host/core/errors.h"
#include "host/io/mesh_formats.h"
#include "host/io/whole_file.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

/// A tetrahedron with every attribute a writer knows; coordinates that floats hold.
TriMesh tetrahedron() {
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1.5, 0, 0}, {0, -2.25, 0}, {0, 0, 1e-3F}};
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    mesh.attributes.push_back({"normal", 3, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1}});
    mesh.attributes.push_back({"colour", 3, {0, 1, 0.2F, 1, 1, 1, 0, 0, 0, 0.6F, 0.4F, 0.8F}});
    mesh.attributes.push_back({"sigma", 1, {0.1F, 0.2F, 0.3F, 0.4F}});
    mesh.attributes.push_back({"pair", 2, {1, 2, 3, 4, 5, 6, 7, 8}});
    return mesh;
}

void expect_same_geometry(const TriMesh& a, const TriMesh& b) {
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.triangles, b.triangles);
}

void expect_attribute(const TriMesh& mesh, const VertexAttribute& expected, float tolerance) {
    const VertexAttribute* found = mesh.find_attribute(expected.name);
    ASSERT_NE(found, nullptr) << expected.name;
    EXPECT_EQ(found->components, expected.components);
    ASSERT_EQ(found->values.size(), expected.values.size());
    for (std::size_t i = 0; i < expected.values.size(); ++i)
        EXPECT_NEAR(found->values[i], expected.values[i], tolerance) << expected.name << i;
}

TEST(MeshIo, PlyRoundTripKeepsEveryAttribute) {
    const TemporaryFolder folder;
    const TriMesh mesh = tetrahedron();
    write_mesh(folder / "a.ply", mesh);
    const TriMesh back = read_mesh(folder / "a.ply");
    expect_same_geometry(back, mesh);
    EXPECT_EQ(back.attributes.size(), 4U);
    for (const VertexAttribute& attribute : mesh.attributes)  // colours: one of 255 steps
        expect_attribute(back, attribute, attribute.name == "colour" ? 1.0F / 510 : 0.0F);
}

TEST(MeshIo, ObjRoundTripIsExact) {
    const TemporaryFolder folder;
    TriMesh mesh = tetrahedron();
    mesh.positions[1].x() = 1.0 / 3;  // text keeps doubles
    write_mesh(folder / "a.obj", mesh);
    const TriMesh back = read_mesh(folder / "a.obj");
    expect_same_geometry(back, mesh);
    expect_attribute(back, mesh.attributes[0], 1e-7F);  // normalised once more: rounding
    expect_attribute(back, mesh.attributes[1], 0.0F);
}

TEST(MeshIo, OffRoundTripIsExact) {
    const TemporaryFolder folder;
    TriMesh mesh = tetrahedron();
    mesh.positions[1].x() = 1.0 / 3;
    write_mesh(folder / "a.off", mesh);
    expect_same_geometry(read_mesh(folder / "a.off"), mesh);
}

TEST(MeshIo, StlRoundTripMergesVertices) {
    const TemporaryFolder folder;
    const TriMesh mesh = tetrahedron();
    write_mesh(folder / "a.STL", mesh);
    EXPECT_EQ(read_whole_file(folder / "a.STL").size(), 84U + 4 * 50U);
    const TriMesh back = read_mesh(folder / "a.STL");
    ASSERT_EQ(back.positions.size(), 4U);
    ASSERT_EQ(back.triangles.size(), 4U);
    for (std::size_t t = 0; t < 4; ++t)
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_EQ(back.positions[back.triangles[t][k]], mesh.positions[mesh.triangles[t][k]]);
}

TEST(MeshIo, ScalesByTheUnit) {
    EXPECT_EQ(mm_per_unit("m"), 1000.0);
    EXPECT_EQ(mm_per_unit("in"), 25.4);
    EXPECT_EQ(mm_per_unit("um"), 0.001);
    EXPECT_EQ(mm_per_unit("mm"), 1.0);
    EXPECT_THROW(mm_per_unit("ft"), Error);
    const TriMesh mesh = parse_mesh("v 1 2 3\n", "a.obj", {.mm_per_unit = 25.4});
    EXPECT_EQ(mesh.positions[0], Eigen::Vector3d(25.4, 50.8, 25.4 * 3));
}

TEST(MeshIo, RefusesOtherEndings) {
    const TemporaryFolder folder;
    EXPECT_NE(message_of([] { parse_mesh("", "a.fbx"); }).find("found .fbx"), std::string::npos);
    EXPECT_NE(message_of([] { parse_mesh("", "noending"); }).find("found no ending"),
              std::string::npos);
    EXPECT_THROW(write_mesh(folder / "a.pcd", tetrahedron()), FileError);
    EXPECT_THROW(write_points(folder / "a.glb", {}), FileError);
}

TEST(MeshIo, AMillionVerticesTakeWellUnderASecond) {
    const TemporaryFolder folder;
    TriMesh mesh;
    std::mt19937 rng(1);
    std::uniform_real_distribution<float> mm(-100, 100);
    for (int i = 0; i < 1'000'000; ++i)
        mesh.positions.emplace_back(static_cast<double>(mm(rng)), static_cast<double>(mm(rng)),
                                    static_cast<double>(mm(rng)));
    for (std::uint32_t i = 0; i < 2'000'000; ++i)
        mesh.triangles.push_back({i % 1'000'000, (i + 1) % 1'000'000, (i + 2) % 1'000'000});
    const auto clock = [] { return std::chrono::steady_clock::now(); };
    const auto seconds = [](auto a, auto b) {
        return std::chrono::duration<double>(b - a).count();
    };
    const auto begin = clock();
    const std::string bytes = format_ply(mesh.positions, mesh.triangles, {}, true);
    const auto written = clock();
    const TriMesh back = parse_mesh(bytes, "million.ply");
    const auto read = clock();
    std::printf("1 M vertices, 2 M triangles (%zu MB): write %.3f s, read %.3f s\n",
                bytes.size() >> 20, seconds(begin, written), seconds(written, read));
    expect_same_geometry(back, mesh);
}

/// Reads the JSON number after "key": in a text; -1 if there is none.
long long json_number(const std::string& json, const std::string& key) {
    const std::size_t at = json.find("\"" + key + "\":");
    return at == std::string::npos ? -1 : std::stoll(json.substr(at + key.size() + 3));
}

std::uint32_t word_at(const std::string& bytes, std::size_t at) {
    std::uint32_t value;
    std::memcpy(&value, bytes.data() + at, 4);
    return value;
}

TEST(MeshIo, GlbHoldsToTheSpecification) {
    const TriMesh mesh = tetrahedron();
    const std::string glb = format_glb(mesh);
    EXPECT_EQ(glb.substr(0, 4), "glTF");
    EXPECT_EQ(word_at(glb, 4), 2U);
    EXPECT_EQ(word_at(glb, 8), glb.size());
    const std::size_t json_size = word_at(glb, 12);
    EXPECT_EQ(json_size % 4, 0U);
    EXPECT_EQ(glb.substr(16, 4), "JSON");
    const std::string json = glb.substr(20, json_size);
    const std::size_t bin = 20 + json_size;
    EXPECT_EQ(word_at(glb, bin + 4), 0x004E4942U);
    EXPECT_EQ(bin + 8 + word_at(glb, bin), glb.size());
    EXPECT_NE(json.find("\"POSITION\":0"), std::string::npos);
    EXPECT_NE(json.find("\"NORMAL\":1"), std::string::npos);
    EXPECT_NE(json.find("\"COLOR_0\":2"), std::string::npos);
    EXPECT_NE(json.find("\"indices\":3"), std::string::npos);
    EXPECT_NE(json.find("\"min\":[0,-2.25,0],\"max\":[1.5,0,0.001]"), std::string::npos) << json;
    EXPECT_EQ(json_number(json.substr(json.find("buffers\"")), "byteLength"), 3 * 48 + 48);
    float x;
    std::memcpy(&x, glb.data() + bin + 8 + 12, 4);  // second position
    EXPECT_EQ(x, 1.5F);
    EXPECT_EQ(word_at(glb, bin + 8 + 3 * 48 + 4), 2U);  // second index
    EXPECT_EQ(format_glb({}).substr(0, 4), "glTF");
}

TEST(PlyMesh, CutsPolygonsIntoFansAndStrips) {
    const std::string header =
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\n"
        "property float y\nproperty float z\n";
    const std::string points = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 2 0\n";
    const TriMesh fan = parse_mesh(header +
                                       "element face 3\nproperty list uchar int vertex_index\n"
                                       "end_header\n" +
                                       points + "5 0 1 2 3 4\n2 0 1\n0\n",
                                   "fan.ply");
    EXPECT_EQ(fan.triangles, (decltype(fan.triangles){{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
    const TriMesh strip = parse_mesh(
        header + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" +
            points + "8 0 1 2 3 -1 2 3 4\n",
        "strip.ply");
    EXPECT_EQ(strip.triangles, (decltype(strip.triangles){{0, 1, 2}, {2, 1, 3}, {2, 3, 4}}));
}

TEST(PlyMesh, WritesALoneRedAsANumber) {  // found by fuzzing: declared uchar, written float
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}};
    mesh.attributes.push_back({"red", 1, {3.5F}});
    const std::string bytes = format_ply(mesh.positions, {}, mesh.attributes, true);
    expect_attribute(parse_mesh(bytes, "a.ply"), mesh.attributes[0], 0.0F);
}

TEST(PlyMesh, RefusesWhatItCannotMean) {
    const std::string good =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
        "property float y\nproperty float z\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    const auto with = [&](const std::string& what, const std::string& by) {
        std::string text = good;
        text.replace(text.find(what), what.size(), by);
        return message_of([&] { parse_mesh(text, "a.ply"); });
    };
    EXPECT_EQ(with("3 0 1 2", "3 0 1 2"), "");
    EXPECT_NE(with("3 0 1 2", "3 0 1 3").find("index of 0 to 2, found 3"), std::string::npos);
    EXPECT_NE(with("3 0 1 2", "3 0 1 -1").find("found -1"), std::string::npos);
    EXPECT_NE(with("3 0 1 2", "2000000 0 1 2").find("claims 2000000 values"), std::string::npos);
    EXPECT_NE(with("3 0 1 2", "-3 0 1 2").find("length of list"), std::string::npos);
    EXPECT_NE(with("1 0 0\n", "1 nan 0\n").find("row 1: expected finite"), std::string::npos);
    EXPECT_NE(with("vertex 3", "vertex -3").find("count of at least 0"), std::string::npos);
    EXPECT_NE(with("vertex 3", "vertex 99999999999999").find("more rows"), std::string::npos);
    EXPECT_NE(with("float x", "float32x x").find("expected a type"), std::string::npos);
    EXPECT_NE(with("uchar int", "float int").find("integer type"), std::string::npos);
    EXPECT_NE(with("ascii", "utf8").find("expected format"), std::string::npos);
    EXPECT_NE(with("element face", "element vertex").find("stands twice"), std::string::npos);
    EXPECT_NE(with("end_header", "end_head").find("line 9"), std::string::npos);
    for (std::size_t n = 0; n + 2 < good.size(); ++n)
        EXPECT_THROW(parse_mesh(good.substr(0, n), "cut.ply"), FileError) << n;
}

TEST(ObjFile, ReadsNegativeIndicesSlashesAndContinuations) {
    const TriMesh mesh = parse_mesh(
        "\xEF\xBB\xBF# mark\r\nv 0 0 0\nv 1 0 0 # c\nv +1 1e0 0\nvt 0 0\nvn 0 0 2\n"
        "f -3/1/1 -2//-1 \\\n -1/-1\nf 1 2 3 # four\ng x\nusemtl y\nl 1 2\n",
        "a.obj");
    EXPECT_EQ(mesh.triangles, (decltype(mesh.triangles){{0, 1, 2}, {0, 1, 2}}));
    const VertexAttribute* normal = mesh.find_attribute("normal");
    ASSERT_NE(normal, nullptr);
    EXPECT_EQ(normal->values, (std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 0}));
}

TEST(ObjFile, FillsMissingColoursWithWhite) {
    const TriMesh mesh = parse_mesh("v 0 0 0\nv 0 0 0 0.5 0.25 0\nv 0 0 0\n", "a.obj");
    const VertexAttribute* colour = mesh.find_attribute("colour");
    ASSERT_NE(colour, nullptr);
    EXPECT_EQ(colour->values, (std::vector<float>{1, 1, 1, 0.5F, 0.25F, 0, 1, 1, 1}));
}

TEST(ObjFile, RefusesWithTheLine) {
    const auto message = [](const std::string& text) {
        return message_of([&] { parse_mesh(text, "a.obj"); });
    };
    EXPECT_NE(message("v 0 0 0\nf 1 1 2\n").find("a.obj: line 2: expected the index of a vertex"),
              std::string::npos);
    EXPECT_NE(message("v 0 0 0\nf 1 1 0\n").find("found '0'"), std::string::npos);
    EXPECT_NE(message("v 0 0 0\nf 1 1 -2\n").find("found '-2'"), std::string::npos);
    EXPECT_NE(message("v 0 0 0\nf 1/9 1 1\n").find("texture vertex"), std::string::npos);
    EXPECT_NE(message("v 0 0 0\nf 1 1\n").find("at least 3 corners"), std::string::npos);
    EXPECT_NE(message("v 0 0\n").find("end of the line"), std::string::npos);
    EXPECT_NE(message("v 0 0 nan\n").find("finite"), std::string::npos);
    EXPECT_NE(message("v 0 0 1e999\n").find("1e999"), std::string::npos);
    EXPECT_NE(message(std::string("\xFE\xFF\0v", 4)).find("UTF-16"), std::string::npos);
    EXPECT_NE(message(std::string("v\0 \0", 4)).find("UTF-16"), std::string::npos);
}

TEST(StlFile, ReadsAsciiWithSeveralSolids) {
    const std::string facet =
        " facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n"
        "   vertex 1 0 0\n   VERTEX 0 1 -0\n  endloop\n endfacet\n";
    const TriMesh mesh = parse_mesh(
        "solid a b\n" + facet + "endsolid a b\nsolid c\n" + facet + "endsolid\n", "a.stl");
    EXPECT_EQ(mesh.positions.size(), 3U);
    EXPECT_EQ(mesh.triangles, (decltype(mesh.triangles){{0, 1, 2}, {0, 1, 2}}));
}

TEST(StlFile, ReadsBinarySolidsInARow) {
    const std::string one = format_stl(tetrahedron());
    std::string solid = one;  // binary files may begin with "solid", too
    solid.replace(0, 5, "solid");
    const TriMesh mesh = parse_mesh(one + solid, "a.stl");
    EXPECT_EQ(mesh.positions.size(), 4U);
    EXPECT_EQ(mesh.triangles.size(), 8U);
}

TEST(StlFile, RefusesWhatIsWrong) {
    const auto message = [](const std::string& text) {
        return message_of([&] { parse_mesh(text, "a.stl"); });
    };
    const std::string binary = format_stl(tetrahedron());
    EXPECT_EQ(message(binary), "");
    EXPECT_NE(message(binary.substr(0, 200)).find("expected 284 bytes, found 200"),
              std::string::npos);
    for (std::size_t n = 0; n < binary.size(); ++n)
        EXPECT_NE(message(binary.substr(0, n)), "") << n;
    std::string nan = binary;
    for (std::size_t i = 96; i < 100; ++i) nan[i] = '\xFF';
    EXPECT_NE(message(nan).find("byte 96: facet 0"), std::string::npos);
    EXPECT_NE(message("solid\nfacet\nvertex 0 0 0\nendfacet\n").find("3 vertices, found 1"),
              std::string::npos);
    EXPECT_NE(message("solid\nvertex 0 0 0\n").find("outside a facet"), std::string::npos);
    EXPECT_NE(message("solid\nfacet\nvertex 0 0\n").find("line 3"), std::string::npos);
    EXPECT_NE(message("solid\nfacet\n").find("ends inside a facet"), std::string::npos);
    EXPECT_NE(message("solid\nrubbish\n").find("line of an ascii STL"), std::string::npos);
    EXPECT_NE(message("hello").find("84 bytes"), std::string::npos);
}

TEST(OffFile, ReadsItsKinds) {
    const std::string body = "3 1 0\n0 0 0\n# c\n1 0 0\n\n0 1 0\n3 0 1 2 255 0 0\n";
    for (const std::string head : {"OFF\n", "OFF ", "OFF", "\t OFF # c\n"})
        EXPECT_EQ(parse_mesh(head + body, "a.off").triangles.size(), 1U) << head;
    const TriMesh mesh = parse_mesh("CNOFF 1 0 0\n1 2 3  0 0 1  51 0.5 255 255\n", "a.off");
    EXPECT_EQ(mesh.positions[0], Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(mesh.find_attribute("normal")->values, (std::vector<float>{0, 0, 1}));
    EXPECT_EQ(mesh.find_attribute("colour")->values, (std::vector<float>{0.2F, 0.5F, 1}));
}

TEST(OffFile, RefusesWhatIsWrong) {
    const auto message = [](const std::string& text) {
        return message_of([&] { parse_mesh(text, "a.off"); });
    };
    EXPECT_NE(message("PLY\n").find("expected 'OFF'"), std::string::npos);
    EXPECT_NE(message("4OFF 1 0 0\n").find("expected 'OFF'"), std::string::npos);
    EXPECT_NE(message("OFF BINARY\n").find("binary"), std::string::npos);
    EXPECT_NE(message("OFF 99999 0 0\n").find("number of vertices"), std::string::npos);
    EXPECT_NE(message("OFF 1 -1 0\n0 0 0\n").find("number of faces"), std::string::npos);
    EXPECT_NE(message("OFF 1 1 0\n0 0 0\n3 0 0 1\n").find("line 3: expected a vertex index"),
              std::string::npos);
    EXPECT_NE(message("OFF 2 0 0\n0 0 0\n").find("end of the file"), std::string::npos);
    EXPECT_NE(message(""), "");
}

}  // namespace
}  // namespace stria
