#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "host/core/errors.h"
#include "host/io/mesh_formats.h"
#include "host/io/mesh_io.h"
#include "host/io/whole_file.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

PointCloud small_cloud() {
    PointCloud cloud;
    cloud.positions = {{1.5, 2, 3}, {-4, 0.25, 6}, {7, 8, -9}};
    cloud.attributes.push_back({"normal", 3, {1, 0, 0, 0, 1, 0, 0, 0, 1}});
    cloud.attributes.push_back({"intensity", 1, {0.5F, 0.25F, 4}});
    return cloud;
}

void expect_same(const PointCloud& a, const PointCloud& b, std::size_t attributes) {
    EXPECT_EQ(a.positions, b.positions);
    ASSERT_GE(a.attributes.size(), attributes);
    for (std::size_t i = 0; i < attributes; ++i) {
        EXPECT_EQ(a.attributes[i].name, b.attributes[i].name);
        EXPECT_EQ(a.attributes[i].values, b.attributes[i].values);
    }
}

TEST(PointsIo, RoundTripsInEveryFormat) {
    const TemporaryFolder folder;
    const PointCloud cloud = small_cloud();
    for (const std::string ending : {"ply", "PCD", "csv", "xyz"}) {
        write_points(folder / ("a." + ending), cloud);
        expect_same(read_points(folder / ("a." + ending)), cloud, ending == "xyz" ? 1 : 2);
    }
}

TEST(PointsIo, DropsAndCountsPointsThatAreNotFinite) {
    const PointCloud cloud = parse_points("1 2 3 1\nnan 0 0 2\n0 inf 0 3\n4 5 6 4\n", "a.xyz");
    EXPECT_EQ(cloud.dropped, 2U);
    ASSERT_EQ(cloud.positions.size(), 2U);
    EXPECT_EQ(cloud.positions[1], Eigen::Vector3d(4, 5, 6));
    EXPECT_EQ(cloud.attributes.at(0).values, (std::vector<float>{1, 4}));
}

TEST(XyzFile, ReadsSeparatorsHeadersAndComments) {
    const PointCloud cloud =
        parse_points("// c\n\"X\"; Y ,Z,Intensity\r\n1;2;3;9\n# c\n\n4 , 5,6\t7 # end\n", "a.csv");
    EXPECT_EQ(cloud.positions[1], Eigen::Vector3d(4, 5, 6));
    EXPECT_EQ(cloud.attributes.at(0).name, "intensity");
    EXPECT_EQ(cloud.attributes.at(0).values, (std::vector<float>{9, 7}));
    const PointCloud reordered = parse_points("z,y,x\n1,2,3\n", "a.csv");
    EXPECT_EQ(reordered.positions[0], Eigen::Vector3d(3, 2, 1));
}

TEST(XyzFile, TakesSixColumnsForNormalsOnlyIfTheyAreUnitVectors) {
    EXPECT_EQ(parse_points("0 0 0 0.6 0.8 0\n", "a.xyz").attributes.at(0).name, "normal");
    const PointCloud cloud = parse_points("0 0 0 200 100 50\n", "a.xyz");
    ASSERT_EQ(cloud.attributes.size(), 3U);
    EXPECT_EQ(cloud.attributes[0].name, "column4");
}

TEST(XyzFile, RefusesWithTheLine) {
    const auto message = [](const std::string& text) {
        return message_of([&] { parse_points(text, "a.csv"); });
    };
    EXPECT_NE(message("1 2 3\n1 2\n").find("line 2"), std::string::npos);
    EXPECT_NE(message("1 2 3\n1 2 3 4\n").find("found more"), std::string::npos);
    EXPECT_NE(message("1 2\n").find("at least 3"), std::string::npos);
    EXPECT_NE(message("a,b,c\n1,2,3\n").find("column 'x'"), std::string::npos);
    EXPECT_NE(message("1 2 3\n1 x 3\n").find("found 'x'"), std::string::npos);
    EXPECT_EQ(parse_points("", "a.xyz").positions.size(), 0U);
}

const std::string kPcd =
    "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\n"
    "COUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\n";

TEST(PcdFile, ReadsAsciiWithPackedColour) {
    const PointCloud cloud =
        parse_points(kPcd + "DATA ascii\n1 2 3 16711935\n4 5 6 255\n", "a.pcd");
    EXPECT_EQ(cloud.positions[1], Eigen::Vector3d(4, 5, 6));
    EXPECT_EQ(cloud.attributes.at(0).name, "colour");
    EXPECT_EQ(cloud.attributes[0].values, (std::vector<float>{1, 0, 1, 0, 0, 1}));
}

/// The two points' values, one field after the other or one point after the other.
std::string pcd_bytes(bool by_field) {
    const float x[2] = {1, 4}, y[2] = {2, 5}, z[2] = {3, 6};
    const std::uint32_t rgb[2] = {0xFF00FF, 0x0000FF};
    std::string bytes;
    const auto put = [&](const void* from) { bytes.append(static_cast<const char*>(from), 4); };
    if (by_field)
        for (const void* from : {static_cast<const void*>(x), static_cast<const void*>(y),
                                 static_cast<const void*>(z), static_cast<const void*>(rgb)})
            bytes.append(static_cast<const char*>(from), 8);
    else
        for (int i = 0; i < 2; ++i) {
            put(x + i);
            put(y + i);
            put(z + i);
            put(rgb + i);
        }
    return bytes;
}

std::string word(std::size_t value) {
    std::string bytes;
    for (int k = 0; k < 4; ++k) bytes += static_cast<char>(value >> (8 * k));
    return bytes;
}

/// LZF without a single back reference: 32 literals are one run.
std::string stored(const std::string& plain) { return static_cast<char>(plain.size() - 1) + plain; }

TEST(PcdFile, ReadsBinaryAndCompressed) {
    const PointCloud ascii =
        parse_points(kPcd + "DATA ascii\n1 2 3 16711935\n4 5 6 255\n", "a.pcd");
    expect_same(parse_points(kPcd + "DATA binary\n" + pcd_bytes(false), "a.pcd"), ascii, 1);
    const std::string packed = stored(pcd_bytes(true));
    expect_same(
        parse_points(kPcd + "DATA binary_compressed\n" + word(packed.size()) + word(32) + packed,
                     "a.pcd"),
        ascii, 1);
}

TEST(PcdFile, RefusesWhatIsWrong) {
    const auto message = [](const std::string& text) {
        return message_of([&] { parse_points(text, "a.pcd"); });
    };
    const std::string binary = kPcd + "DATA binary\n" + pcd_bytes(false);
    for (std::size_t n = 0; n < binary.size(); ++n)
        EXPECT_NE(message(binary.substr(0, n)), "") << n;
    const std::string packed = stored(pcd_bytes(true));
    const std::string compressed =
        kPcd + "DATA binary_compressed\n" + word(packed.size()) + word(32) + packed;
    for (std::size_t n = 0; n < compressed.size(); ++n)
        EXPECT_NE(message(compressed.substr(0, n)), "") << n;
    const auto with = [&](const std::string& what, const std::string& by) {
        std::string text = kPcd + "DATA ascii\n1 2 3 0\n4 5 6 0\n";
        text.replace(text.find(what), what.size(), by);
        return message(text);
    };
    EXPECT_NE(with("POINTS 2", "POINTS 4000000000").find("can hold"), std::string::npos);
    EXPECT_NE(with("POINTS 2", "POINTS 3").find("3 points"), std::string::npos);
    EXPECT_NE(with("SIZE 4", "SIZE 3").find("field x"), std::string::npos);
    EXPECT_NE(with("TYPE F", "TYPE Q").find("field x"), std::string::npos);
    EXPECT_NE(with("COUNT 1", "COUNT -1").find("COUNT"), std::string::npos);
    EXPECT_NE(with("DATA ascii", "DATA zip").find("found 'zip'"), std::string::npos);
    EXPECT_NE(with("FIELDS x", "FIELDS w").find("column 'x'"), std::string::npos);
    const std::string bomb =
        kPcd + "DATA binary_compressed\n" + word(packed.size()) + word(0xFFFFFFF0U) + packed;
    EXPECT_NE(message(bomb).find("more than LZF can pack"), std::string::npos);
}

/// A slow, obvious compressor: references of length 3 and more wherever the past repeats.
std::string lzf_compress(const std::string& plain) {
    std::string out, literals;
    const auto flush = [&] {
        for (std::size_t i = 0; i < literals.size(); i += 32) {
            const std::string run = literals.substr(i, 32);
            out += static_cast<char>(run.size() - 1);
            out += run;
        }
        literals.clear();
    };
    for (std::size_t at = 0; at < plain.size();) {
        std::size_t length = 0, distance = 0;
        for (std::size_t back = 1; back <= std::min<std::size_t>(at, 8192); ++back) {
            std::size_t n = 0;
            while (n < 264 && at + n < plain.size() && plain[at + n - back] == plain[at + n]) ++n;
            if (n > length) {
                length = n;
                distance = back;
            }
        }
        if (length < 3) {
            literals += plain[at++];
            continue;
        }
        flush();
        const std::size_t d = distance - 1, l = length - 2;
        out += static_cast<char>((std::min<std::size_t>(l, 7) << 5) | (d >> 8));
        if (l >= 7) out += static_cast<char>(l - 7);
        out += static_cast<char>(d & 255);
        at += length;
    }
    flush();
    return out;
}

TEST(Lzf, RestoresWhatWasPacked) {
    std::mt19937 rng(9);
    for (const std::size_t alphabet : {1U, 2U, 5U, 256U})
        for (const std::size_t size : {0U, 1U, 31U, 33U, 300U, 3000U}) {
            std::string plain;
            for (std::size_t i = 0; i < size; ++i) plain += static_cast<char>(rng() % alphabet);
            EXPECT_EQ(lzf_decompress(lzf_compress(plain), size), plain);
        }
}

TEST(Lzf, RefusesDamageAndWrongSizes) {
    const std::string plain(1000, 'a');
    const std::string packed = lzf_compress(plain);
    EXPECT_EQ(lzf_decompress(packed, 999), "");
    EXPECT_EQ(lzf_decompress(packed, 1001), "");
    for (std::size_t n = 0; n < packed.size(); ++n)
        EXPECT_EQ(lzf_decompress(packed.substr(0, n), 1000), "") << n;
    EXPECT_EQ(lzf_decompress(std::string("\x20\x05", 2), 3), "");  // points before the start
}

}  // namespace
}  // namespace stria
