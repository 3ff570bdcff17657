#include "host/io/image_io.h"

#include <gtest/gtest.h>
#include <tiffio.h>

#include <random>

#include "host/core/errors.h"
#include "host/io/whole_file.h"
#include "tests/host/io/encoded_images.h"
#include "tests/host/io/handmade_png.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

template <typename T>
Image<T> random_image(int width, int height, int channels, unsigned seed) {
    std::mt19937 rng(seed);
    Image<T> image(width, height, channels);
    for (T& value : image.values) value = static_cast<T>(rng());
    return image;
}

template <typename T>
std::vector<std::uint16_t> widened(const Image<T>& image) {
    return {image.values.begin(), image.values.end()};
}

TEST(ImageIo, PngRoundTripKeepsEveryValue) {
    for (int channels : {1, 3}) {
        const auto image = random_image<std::uint8_t>(37, 21, channels, 1);
        const LoadedImage loaded = parse_image(encode_png(image), "a.png");
        EXPECT_EQ(loaded.bits, 8);
        EXPECT_EQ(loaded.pixels.channels, channels);
        EXPECT_EQ(loaded.pixels.width, 37);
        EXPECT_EQ(loaded.pixels.height, 21);
        EXPECT_EQ(loaded.pixels.values, widened(image));
    }
    const auto deep = random_image<std::uint16_t>(13, 5, 1, 2);
    const LoadedImage loaded = parse_image(encode_png(deep), "a.png");
    EXPECT_EQ(loaded.bits, 16);
    EXPECT_EQ(loaded.pixels.values, deep.values);
}

/// The sample that every handmade PNG below holds.
unsigned pattern(unsigned x, unsigned y, unsigned c) { return 40503U * (x + 7 * y) + 977 * c; }

TEST(ImageIo, ReadsEveryKindOfPng) {
    for (const bool interlaced : {false, true})
        for (const unsigned type : {0U, 2U, 4U, 6U})
            for (const unsigned bits : {1U, 2U, 4U, 8U, 16U}) {
                if (type != 0 && bits < 8) continue;
                const unsigned top = (1U << bits) - 1;
                HandmadePng png{11, 9, bits, type, interlaced, "", "", {}};
                png.sample = [&](unsigned x, unsigned y, unsigned c) {
                    return pattern(x, y, c) & top;
                };
                const LoadedImage loaded = parse_image(encode(png), "a.png");
                const int channels = type & 2 ? 3 : 1;
                ASSERT_EQ(loaded.pixels.channels, channels);
                EXPECT_EQ(loaded.bits, bits == 16 ? 16 : 8);
                for (int y = 0; y < 9; ++y)
                    for (int x = 0; x < 11; ++x)
                        for (int c = 0; c < channels; ++c) {
                            const unsigned stored =
                                pattern(static_cast<unsigned>(x), static_cast<unsigned>(y),
                                        static_cast<unsigned>(c)) &
                                top;
                            const unsigned full = bits < 8 ? stored * (255 / top) : stored;
                            EXPECT_EQ(loaded.pixels.at(x, y, c), full) << type << " " << bits;
                        }
            }
}

TEST(ImageIo, ExpandsAPaletteAndDropsItsTransparency) {
    HandmadePng png{5, 2, 2, 3, false, std::string("\x0A\x14\x1E\xFF\x00\x80", 6), "\x40", {}};
    png.sample = [](unsigned x, unsigned, unsigned) { return x % 2; };
    const LoadedImage loaded = parse_image(encode(png), "a.png");
    ASSERT_EQ(loaded.pixels.channels, 3);
    EXPECT_EQ(loaded.pixels.at(2, 1, 1), 20);
    EXPECT_EQ(loaded.pixels.at(3, 0, 0), 255);
    EXPECT_EQ(loaded.pixels.at(3, 0, 2), 128);
    png.sample = [](unsigned, unsigned, unsigned) { return 3U; };  // beyond the palette
    (void)message_of([&] { parse_image(encode(png), "a.png"); });
}

TEST(ImageIo, WritesAndReadsFiles) {
    const TemporaryFolder folder;
    const auto image = random_image<std::uint8_t>(8, 8, 1, 3);
    write_png(folder / "a.dat", image);  // recognised by content, not by name
    EXPECT_EQ(read_grey_image(folder / "a.dat").values, image.values);
}

TEST(ImageIo, RefusesATruncatedPngAtEveryByte) {
    const std::string bytes = encode_png(random_image<std::uint8_t>(9, 7, 3, 4));
    for (std::size_t n = 0; n < bytes.size(); ++n)
        EXPECT_THROW(parse_image(bytes.substr(0, n), "cut.png"), FileError) << n;
}

TEST(ImageIo, SurvivesFlippedBytes) {
    std::mt19937 rng(5);
    const std::string png = encode_png(random_image<std::uint8_t>(9, 7, 3, 4));
    const std::string jpeg = encode_jpeg(random_image<std::uint8_t>(16, 16, 3, 4), 90);
    const std::string tiff = encode_tiff(random_image<std::uint8_t>(9, 7, 3, 4), COMPRESSION_LZW);
    for (const std::string& whole : {png, jpeg, tiff})
        for (int i = 0; i < 500; ++i) {
            std::string bytes = whole;
            bytes[rng() % bytes.size()] = static_cast<char>(rng());
            (void)message_of([&] { parse_image(bytes, "flipped"); });  // any answer, no crash
        }
}

TEST(ImageIo, ReadsJpegWithinItsQuantisation) {
    Image<std::uint8_t> ramp(64, 48, 3);
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x) {
            ramp.at(x, y, 0) = static_cast<std::uint8_t>(2 * x + 60);
            ramp.at(x, y, 1) = static_cast<std::uint8_t>(3 * y + 50);
            ramp.at(x, y, 2) = 90;
        }
    const LoadedImage loaded = parse_image(encode_jpeg(ramp, 100), "a.jpg");
    ASSERT_EQ(loaded.pixels.channels, 3);
    for (std::size_t i = 0; i < ramp.values.size(); ++i)
        EXPECT_NEAR(loaded.pixels.values[i], ramp.values[i], 6) << i;  // chroma is subsampled
}

TEST(ImageIo, RefusesATruncatedJpeg) {
    const std::string bytes = encode_jpeg(random_image<std::uint8_t>(16, 16, 1, 4), 80);
    for (std::size_t n = 0; n + 2 < bytes.size(); ++n)  // the end marker alone may miss
        EXPECT_THROW(parse_image(bytes.substr(0, n), "cut.jpg"), FileError) << n;
}

TEST(ImageIo, ReadsTiff) {
    for (int compression : {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE})
        for (int channels : {1, 3}) {
            const auto narrow = random_image<std::uint8_t>(19, 11, channels, 6);
            LoadedImage loaded = parse_image(encode_tiff(narrow, compression), "a.tif");
            EXPECT_EQ(loaded.bits, 8);
            EXPECT_EQ(loaded.pixels.values, widened(narrow));
            const auto wide = random_image<std::uint16_t>(19, 11, channels, 7);
            loaded = parse_image(encode_tiff(wide, compression), "a.tif");
            EXPECT_EQ(loaded.bits, 16);
            EXPECT_EQ(loaded.pixels.values, wide.values);
        }
}

TEST(ImageIo, NeverCrashesOnATruncatedTiff) {
    const std::string bytes = encode_tiff(random_image<std::uint8_t>(9, 7, 1, 4), COMPRESSION_LZW);
    for (std::size_t n = 0; n < bytes.size(); ++n)
        EXPECT_THROW(parse_image(bytes.substr(0, n), "cut.tif"), FileError) << n;
}

TEST(ImageIo, RefusesASizeThatTheFileCannotHold) {
    std::string bytes = encode_png(Image<std::uint8_t>(4, 4));
    bytes[18] = 0x40;  // width 16388 in IHDR: the checksum no longer fits either
    EXPECT_THROW(parse_image(bytes, "bomb.png"), FileError);
    std::string jpeg = encode_jpeg(Image<std::uint8_t>(16, 16), 50);
    const std::size_t sof = jpeg.find("\xFF\xC0");
    ASSERT_NE(sof, std::string::npos);
    for (std::size_t i : {5U, 7U}) jpeg[sof + i] = 0x7F;  // 32528 x 32528
    const std::string message = message_of([&] { parse_image(jpeg, "bomb.jpg"); });
    EXPECT_NE(message.find("bomb.jpg: header: "), std::string::npos) << message;
}

TEST(ImageIo, RefusesOtherContent) {
    EXPECT_NE(message_of([] { parse_image("", "e"); }).find("found an empty file"),
              std::string::npos);
    EXPECT_NE(message_of([] { parse_image("GIF89a", "e"); }).find("PNG, JPEG or TIFF"),
              std::string::npos);
}

TEST(ImageIo, FindsTheColourOfTheStripe) {
    LoadedImage image;
    image.pixels = Image<std::uint16_t>(100, 100, 3, 20);
    for (int y = 0; y < 100; ++y) image.pixels.at(50, y, 1) = 200;  // 1 % of the pixels
    EXPECT_EQ(strongest_channel(image), ColourChannel::green);
    EXPECT_EQ(select_channel(image, ColourChannel::automatic).at(50, 3), 200);
    EXPECT_EQ(select_channel(image, ColourChannel::red).at(50, 3), 20);
    // 0.299 * 20 + 0.587 * 200 + 0.114 * 20 = 125.66
    EXPECT_EQ(select_channel(image, ColourChannel::grey).at(50, 3), 126);
}

TEST(ImageIo, ScalesSixteenBitsToEight) {
    const TemporaryFolder folder;
    Grey16Image image(3, 1);
    image.values = {0, 257 * 100, 65535};
    write_png(folder / "a.png", image);
    EXPECT_EQ(read_grey_image(folder / "a.png").values, (std::vector<std::uint8_t>{0, 100, 255}));
}

}  // namespace
}  // namespace stria
