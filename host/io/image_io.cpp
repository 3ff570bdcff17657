#include "host/io/image_io.h"

#include <algorithm>

#include "host/core/errors.h"
#include "host/io/image_codecs.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

/// The 99.9th percentile of one channel above its median.
int contrast(const Image<std::uint16_t>& image, int channel) {
    std::vector<std::size_t> histogram(65536, 0);
    const auto step = static_cast<std::size_t>(image.channels);
    for (std::size_t i = static_cast<std::size_t>(channel); i < image.values.size(); i += step)
        ++histogram[image.values[i]];
    const std::size_t count = image.values.size() / step;
    const auto percentile = [&](std::size_t per_mille) {
        const std::size_t rank = (count * per_mille + 999) / 1000;
        std::size_t seen = 0;
        for (int value = 0; value < 65536; ++value)
            if ((seen += histogram[static_cast<std::size_t>(value)]) >=
                std::max<std::size_t>(rank, 1))
                return value;
        return 65535;
    };
    return percentile(999) - percentile(500);
}

/// Rec. 601 luma, rounded.
std::uint16_t luma(const std::uint16_t* rgb) {
    return static_cast<std::uint16_t>((299U * rgb[0] + 587U * rgb[1] + 114U * rgb[2] + 500U) /
                                      1000U);
}

bool starts_with(std::string_view bytes, std::string_view magic) {
    return bytes.substr(0, magic.size()) == magic;
}

}  // namespace

void check_image_size(const std::string& name, std::size_t file_bytes, std::uint64_t width,
                      std::uint64_t height, std::uint64_t channels) {
    const std::string size = std::to_string(width) + " x " + std::to_string(height);
    if (width < 1 || height < 1 || width > 32768 || height > 32768)
        throw FileError(name, "header", "expected sides of 1 to 32768 px, found " + size);
    const std::uint64_t samples = width * height * channels;
    if (channels > 64 || samples > (std::uint64_t{1} << 28))
        throw FileError(
            name, "header",
            "expected at most 2^28 samples, found " + size + " x " + std::to_string(channels));
    if (samples > 4096 * std::uint64_t{file_bytes} + (1U << 22))
        throw FileError(name, "header",
                        "claims " + size + " px, more than its " + std::to_string(file_bytes) +
                            " bytes can hold");
}

LoadedImage parse_image(std::string_view bytes, const std::string& name) {
    if (starts_with(bytes, "\x89PNG")) return decode_png(bytes, name);
    if (starts_with(bytes, "\xFF\xD8\xFF")) return decode_jpeg(bytes, name);
    if (starts_with(bytes, {"II*\0", 4}) || starts_with(bytes, {"MM\0*", 4}) ||
        starts_with(bytes, {"II+\0", 4}) || starts_with(bytes, {"MM\0+", 4}))
        return decode_tiff(bytes, name);
    throw FileError(name, "byte 0",
                    bytes.empty() ? "expected a PNG, JPEG or TIFF image, found an empty file"
                                  : "expected a PNG, JPEG or TIFF image, found other content");
}

LoadedImage read_image(const std::string& path) {
    return parse_image(read_whole_file(path, std::size_t{1} << 30), path);
}

ColourChannel strongest_channel(const LoadedImage& image) {
    if (image.pixels.channels != 3) return ColourChannel::grey;
    constexpr ColourChannel kNames[] = {ColourChannel::red, ColourChannel::green,
                                        ColourChannel::blue};
    int best = 0, greatest = contrast(image.pixels, 0);
    for (int c = 1; c < 3; ++c)
        if (const int value = contrast(image.pixels, c); value > greatest) {
            greatest = value;
            best = c;
        }
    return kNames[best];
}

Grey16Image select_channel(const LoadedImage& image, ColourChannel channel) {
    if (image.pixels.channels == 1) return image.pixels;
    if (channel == ColourChannel::automatic) channel = strongest_channel(image);
    Grey16Image grey(image.pixels.width, image.pixels.height);
    const std::uint16_t* rgb = image.pixels.values.data();
    const int offset = channel == ColourChannel::green ? 1 : channel == ColourChannel::blue ? 2 : 0;
    for (std::uint16_t& value : grey.values) {
        value = channel == ColourChannel::grey ? luma(rgb) : rgb[offset];
        rgb += 3;
    }
    return grey;
}

ColourChannel colour_channel_from(const std::string& name) {
    if (name == "auto") return ColourChannel::automatic;
    if (name == "red") return ColourChannel::red;
    if (name == "green") return ColourChannel::green;
    if (name == "blue") return ColourChannel::blue;
    if (name == "grey") return ColourChannel::grey;
    throw Error("channel '" + name + "': expected auto, red, green, blue or grey");
}

GreyImage read_grey_image(const std::string& path) {
    const LoadedImage loaded = read_image(path);
    const Grey16Image wide = select_channel(loaded, ColourChannel::grey);
    GreyImage grey(wide.width, wide.height);
    std::transform(
        wide.values.begin(), wide.values.end(), grey.values.begin(), [&](std::uint16_t value) {
            // 65535 / 255 = 257, so that white stays white
            return static_cast<std::uint8_t>(loaded.bits == 16 ? (value + 128U) / 257U : value);
        });
    return grey;
}

void write_png(const std::string& path, const Image<std::uint8_t>& image) {
    write_whole_file(path, encode_png(image));
}
void write_png(const std::string& path, const Grey16Image& image) {
    write_whole_file(path, encode_png(image));
}

}  // namespace stria
