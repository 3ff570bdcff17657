#include "host/io/range_io.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <random>

#include "host/core/errors.h"
#include "host/io/ply_file.h"
#include "host/io/whole_file.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

float small_float(std::mt19937& rng) {
    return std::uniform_real_distribution<float>(-100.0F, 100.0F)(rng);
}

RangePoint random_point(std::mt19937& rng) {
    RangePoint p;
    for (int i = 0; i < 3; ++i) {
        p.position[i] = static_cast<double>(small_float(rng));  // files hold floats
        p.normal[i] = small_float(rng);
        p.error_direction[i] = small_float(rng);
    }
    p.sigma_mm = small_float(rng);
    p.sigma_across_mm = small_float(rng);
    p.sigma_systematic_mm = small_float(rng);
    p.intensity = small_float(rng);
    p.s = static_cast<double>(small_float(rng));
    p.flags = static_cast<std::uint16_t>(rng());
    return p;
}

RangeImage random_image(int width, int height, unsigned seed) {
    std::mt19937 rng(seed);
    RangeImage image = make_range_image(width, height);
    image.kind = MachineKind::rail;
    image.model_hash = "0123abcd";
    image.sensitivity_count = 2;
    image.sensitivity.assign(2 * image.cell_count(), 0.0F);
    for (std::uint32_t cell = 0; cell < image.cell_count(); ++cell) {
        if (rng() % 3 == 0) continue;
        image.mask[cell] = 1;
        image.points[cell] = random_point(rng);
        image.sensitivity[2 * cell] = small_float(rng);
        image.sensitivity[2 * cell + 1] = small_float(rng);
        for (std::uint8_t k = 1; k <= rng() % 3; ++k)
            image.further.push_back({cell, k, random_point(rng)});
    }
    image.stations = {{-1.0 / 3, {1, 2, 1e-9}, {4, 5, 6}}, {0.1, {7, 8, 9}, {1.0 / 7, 0, 0}}};
    return image;
}

void expect_same(const RangePoint& a, const RangePoint& b) {
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.normal, b.normal);
    EXPECT_EQ(a.error_direction, b.error_direction);
    EXPECT_EQ(a.sigma_mm, b.sigma_mm);
    EXPECT_EQ(a.sigma_across_mm, b.sigma_across_mm);
    EXPECT_EQ(a.sigma_systematic_mm, b.sigma_systematic_mm);
    EXPECT_EQ(a.intensity, b.intensity);
    EXPECT_EQ(a.s, b.s);
    EXPECT_EQ(a.flags, b.flags);
}

TEST(RangeIo, RoundTripKeepsEverything) {
    const TemporaryFolder folder;
    const RangeImage image = random_image(13, 9, 1);
    write_range_image(folder / "range.ply", image);
    EXPECT_TRUE(has_range_grid(folder / "range.ply"));
    const RangeImage back = read_range_image(folder / "range.ply");
    EXPECT_EQ(back.width, 13);
    EXPECT_EQ(back.height, 9);
    EXPECT_EQ(back.kind, MachineKind::rail);
    EXPECT_EQ(back.model_hash, image.model_hash);
    EXPECT_EQ(back.mask, image.mask);
    EXPECT_EQ(back.sensitivity_count, 2);
    EXPECT_EQ(back.sensitivity, image.sensitivity);
    for (std::size_t cell = 0; cell < image.cell_count(); ++cell)
        if (image.mask[cell]) expect_same(back.points[cell], image.points[cell]);
    ASSERT_EQ(back.further.size(), image.further.size());
    for (std::size_t i = 0; i < image.further.size(); ++i) {
        EXPECT_EQ(back.further[i].cell, image.further[i].cell);
        EXPECT_EQ(back.further[i].return_index, image.further[i].return_index);
        expect_same(back.further[i].point, image.further[i].point);
    }
    ASSERT_EQ(back.stations.size(), 2U);
    EXPECT_EQ(back.stations[0].s, image.stations[0].s);
    EXPECT_EQ(back.stations[0].camera_in_scan, image.stations[0].camera_in_scan);
    EXPECT_EQ(back.stations[1].laser_in_scan, image.stations[1].laser_in_scan);
    EXPECT_EQ(format_range_image(back), format_range_image(image));
}

TEST(RangeIo, RoundTripsAnEmptyImage) {
    for (const auto& [width, height] : {std::pair(0, 0), std::pair(3, 2)}) {
        const RangeImage back =
            parse_range_image(format_range_image(make_range_image(width, height)), "r.ply");
        EXPECT_EQ(back.width, width);
        EXPECT_EQ(back.height, height);
        EXPECT_EQ(valid_count(back), 0U);
    }
}

/// Stanford's layout, 3 x 2 cells, 3 points.
std::string stanford(const std::string& end) {
    std::string text =
        "ply\nformat ascii 1.0\nobj_info num_cols 3\nobj_info num_rows 2\n"
        "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element range_grid 6\nproperty list uchar int vertex_indices\nend_header\n"
        "1 2 3\n-0.5 1e-3 +4\n7 8 9\n0\n1 0\n0\n1 1\n0\n1 2\n";
    std::string result;
    for (char c : text) result += c == '\n' ? end : std::string(1, c);
    return result;
}

TEST(RangeIo, ReadsStanfordsLayoutWithAnyLineEnd) {
    for (const std::string end : {"\n", "\r\n", "\r"}) {
        const RangeImage image = parse_range_image(stanford(end), "bun.ply", 1000);
        EXPECT_EQ(image.width, 3);
        EXPECT_EQ(image.height, 2);
        EXPECT_EQ(image.mask, (std::vector<std::uint8_t>{0, 1, 0, 1, 0, 1}));
        EXPECT_EQ(image.at(1, 0).position, Eigen::Vector3d(1000, 2000, 3000));
        EXPECT_EQ(image.at(0, 1).position, Eigen::Vector3d(-500, 1, 4000));
        EXPECT_TRUE(image.stations.empty());
        EXPECT_EQ(image.at(1, 0).sigma_mm, 0.0F);
    }
}

template <typename T>
void put_big(std::string& bytes, T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    for (std::size_t i = sizeof(T); i-- > 0;) bytes += raw[i];
}

TEST(RangeIo, ReadsBigEndian) {
    std::string bytes =
        "ply\nformat binary_big_endian 1.0\nobj_info num_cols 2\nobj_info num_rows 1\n"
        "element vertex 1\nproperty float x\nproperty double y\nproperty short z\n"
        "element range_grid 2\nproperty list uchar int vertex_indices\nend_header\n";
    put_big(bytes, 1.5F);
    put_big(bytes, -2.25);
    put_big(bytes, std::int16_t{-300});
    put_big(bytes, std::uint8_t{1});
    put_big(bytes, std::int32_t{0});
    put_big(bytes, std::uint8_t{0});
    const RangeImage image = parse_range_image(bytes, "big.ply");
    EXPECT_EQ(image.mask, (std::vector<std::uint8_t>{1, 0}));
    EXPECT_EQ(image.at(0, 0).position, Eigen::Vector3d(1.5, -2.25, -300));
}

TEST(RangeIo, NamesThePlaceOfAnError) {
    const auto with = [](const std::string& what, const std::string& by) {
        std::string text = stanford("\n");
        text.replace(text.find(what), what.size(), by);
        return message_of([&] { parse_range_image(text, "r.ply"); });
    };
    EXPECT_EQ(with("7 8 9", "7 8 x"),
              "r.ply: line 14: element vertex, row 2 of 3: expected a number, found 'x'");
    EXPECT_NE(with("7 8 9", "7 8 nan").find("row 2: expected finite"), std::string::npos);
    EXPECT_NE(with("1 2\n", "1 3\n").find("below 3, found 3"), std::string::npos);
    EXPECT_NE(with("1 2\n", "2 0 1\n").find("list of 0 or 1 index, found 2"), std::string::npos);
    EXPECT_NE(with("num_cols 3", "num_cols 4").find("= 8 rows of range_grid, found 6"),
              std::string::npos);
    EXPECT_NE(with("num_rows 2", "num_rows x").find("num_rows N"), std::string::npos);
    EXPECT_NE(with("vertex 3", "vertex 3000000000").find("more rows than the file holds"),
              std::string::npos);
    EXPECT_NE(with("range_grid 6", "range_grid 7").find("line 21"), std::string::npos);
    EXPECT_NE(with("property float z", "property float w").find("property 'z'"), std::string::npos);
    EXPECT_NE(with("element range_grid", "element grid").find("range_grid, found none"),
              std::string::npos);
}

TEST(RangeIo, RefusesTruncationAtEveryByte) {
    const std::string ascii = stanford("\n");
    for (std::size_t n = 0; n + 2 < ascii.size(); ++n)  // the last line end may miss
        EXPECT_THROW(parse_range_image(ascii.substr(0, n), "cut"), FileError) << n;
    const std::string binary = format_range_image(random_image(3, 3, 2));
    for (std::size_t n = 0; n < binary.size(); ++n)
        EXPECT_THROW(parse_range_image(binary.substr(0, n), "cut"), FileError) << n;
}

TEST(RangeIo, SurvivesFlippedBytes) {
    std::mt19937 rng(5);
    for (const std::string& whole : {stanford("\n"), format_range_image(random_image(4, 3, 3))})
        for (int i = 0; i < 3000; ++i) {
            std::string bytes = whole;
            for (int k = 0; k < 3; ++k) bytes[rng() % bytes.size()] = static_cast<char>(rng());
            (void)message_of([&] { parse_range_image(bytes, "flipped"); });
        }
}

TEST(RangeIo, RefusesAFurtherReturnOfAnEmptyCell) {
    RangeImage image = make_range_image(2, 1);
    image.further.push_back({1, 1, RangePoint{}});
    EXPECT_THROW(format_range_image(image), std::invalid_argument);
}

TEST(RangeIo, ReadsTheBunnyQuickly) {
    const char* data = std::getenv("STRIA_TEST_DATA");
    if (!data) GTEST_SKIP() << "set STRIA_TEST_DATA to the folder of real data sets";
    const std::string folder = std::string(data) + "/stanford_bunny/";
    const auto begin = std::chrono::steady_clock::now();
    const RangeImage image = read_range_image(folder + "bun000.ply", 1000);
    const double ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    RecordProperty("milliseconds", std::to_string(ms));
    std::printf("bun000.ply: %.1f ms\n", ms);
    EXPECT_EQ(valid_count(image), 40256U);
    EXPECT_EQ(image.width, 512);
    EXPECT_EQ(image.height, 400);
    EXPECT_TRUE(has_range_grid(folder + "bun000.ply"));
    EXPECT_FALSE(has_range_grid(folder + "bun_zipper_res4.ply"));
    // Neighbours in the grid are neighbours on the surface: the scanner's pitch is about 0.5 mm.
    std::size_t near = 0, pairs = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x + 1 < image.width; ++x)
            if (image.has(x, y) && image.has(x + 1, y)) {
                ++pairs;
                near += (image.at(x, y).position - image.at(x + 1, y).position).norm() < 2.0;
            }
    EXPECT_GT(static_cast<double>(near), 0.95 * static_cast<double>(pairs));
}

}  // namespace
}  // namespace stria
