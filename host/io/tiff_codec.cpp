#include <tiffio.h>

#include <algorithm>
#include <cstdarg>
#include <cstring>
#include <memory>
#include <vector>

#include "host/core/errors.h"
#include "host/io/image_codecs.h"

namespace stria {
namespace {

/// The file in memory, as libtiff's callbacks see it, and the first thing it complained about.
struct TiffSource {
    std::string_view bytes;
    toff_t at = 0;
    std::string message;
};

tmsize_t on_read(thandle_t handle, void* out, tmsize_t count) {
    auto* source = static_cast<TiffSource*>(handle);
    if (source->at >= source->bytes.size() || count <= 0) return 0;
    const std::size_t n =
        std::min<std::size_t>(static_cast<std::size_t>(count), source->bytes.size() - source->at);
    std::memcpy(out, source->bytes.data() + source->at, n);
    source->at += n;
    return static_cast<tmsize_t>(n);
}
tmsize_t on_write(thandle_t, void*, tmsize_t) { return 0; }
toff_t on_seek(thandle_t handle, toff_t offset, int whence) {
    auto* source = static_cast<TiffSource*>(handle);
    if (whence == SEEK_CUR) offset += source->at;
    if (whence == SEEK_END) offset += source->bytes.size();
    return source->at = offset;
}
int on_close(thandle_t) { return 0; }
toff_t on_size(thandle_t handle) { return static_cast<TiffSource*>(handle)->bytes.size(); }
int on_map(thandle_t, void**, toff_t*) { return 0; }
void on_unmap(thandle_t, void*, toff_t) {}

int on_error(TIFF*, void* user, const char* /*module*/, const char* format, va_list arguments) {
    auto* source = static_cast<TiffSource*>(user);
    char text[256];
    std::vsnprintf(text, sizeof text, format, arguments);
    if (source->message.empty()) source->message = text;
    return 1;
}
int on_warning(TIFF*, void*, const char*, const char*, va_list) { return 1; }

struct CloseTiff {
    void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using TiffHandle = std::unique_ptr<TIFF, CloseTiff>;

TiffHandle open(TiffSource& source, const std::string& name) {
    TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, tmsize_t{1} << 30);
    TIFFOpenOptionsSetErrorHandlerExtR(options, on_error, &source);
    TIFFOpenOptionsSetWarningHandlerExtR(options, on_warning, &source);
    TiffHandle tiff(TIFFClientOpenExt(name.c_str(), "rm", &source, on_read, on_write, on_seek,
                                      on_close, on_size, on_map, on_unmap, options));
    TIFFOpenOptionsFree(options);
    return tiff;
}

struct TiffLayout {
    std::uint32_t width = 0, height = 0;
    std::uint16_t bits = 1, samples = 1, planar = PLANARCONFIG_CONTIG, format = SAMPLEFORMAT_UINT;
    std::uint16_t photometric = PHOTOMETRIC_MINISBLACK, compression = COMPRESSION_NONE;
};

TiffLayout layout_of(TIFF* tiff) {
    TiffLayout layout;
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &layout.width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &layout.height);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &layout.bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &layout.samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &layout.planar);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &layout.format);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &layout.compression);
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &layout.photometric);
    return layout;
}

/// Copies one row of file samples; alpha and further samples are dropped.
void take_row(const TiffLayout& layout, const std::uint8_t* row, int channels, std::uint16_t* out) {
    const bool invert = layout.photometric == PHOTOMETRIC_MINISWHITE;
    const std::uint16_t top = layout.bits == 8 ? 0xFF : 0xFFFF;
    for (std::size_t x = 0; x < layout.width; ++x)
        for (int c = 0; c < channels; ++c) {
            const std::size_t i = x * layout.samples + static_cast<std::size_t>(c);
            std::uint16_t value = row[i];
            if (layout.bits == 16) std::memcpy(&value, row + 2 * i, 2);
            *out++ = invert ? static_cast<std::uint16_t>(top - value) : value;
        }
}

/// Samples as they stand, without colour conversion. False where libtiff complained.
bool read_samples(TIFF* tiff, const TiffLayout& layout, LoadedImage& loaded) {
    const tmsize_t row_bytes = TIFFScanlineSize(tiff);
    const std::size_t needed = std::size_t{layout.width} * layout.samples * (layout.bits / 8U);
    if (row_bytes <= 0 || static_cast<std::size_t>(row_bytes) < needed) return false;
    std::vector<std::uint8_t> row(static_cast<std::size_t>(row_bytes));
    for (std::uint32_t y = 0; y < layout.height; ++y) {
        if (TIFFReadScanline(tiff, row.data(), y) < 0) return false;
        take_row(layout, row.data(), loaded.pixels.channels,
                 &loaded.pixels.at(0, static_cast<int>(y)));
    }
    return true;
}

/// Palettes, tiles, YCbCr, 1-bit and the like: by libtiff's own conversion to 8-bit colours.
bool read_converted(TIFF* tiff, const TiffLayout& layout, LoadedImage& loaded) {
    char why[1024] = "";
    if (!TIFFRGBAImageOK(tiff, why)) return false;
    std::vector<std::uint32_t> raster(std::size_t{layout.width} * layout.height);
    if (!TIFFReadRGBAImageOriented(tiff, layout.width, layout.height, raster.data(),
                                   ORIENTATION_TOPLEFT, 1))
        return false;
    std::uint16_t* out = loaded.pixels.values.data();
    for (const std::uint32_t pixel : raster) {
        *out++ = static_cast<std::uint16_t>(TIFFGetR(pixel));
        if (loaded.pixels.channels == 1) continue;
        *out++ = static_cast<std::uint16_t>(TIFFGetG(pixel));
        *out++ = static_cast<std::uint16_t>(TIFFGetB(pixel));
    }
    return true;
}

}  // namespace

LoadedImage decode_tiff(std::string_view bytes, const std::string& name) {
    TiffSource source{bytes, 0, ""};
    const TiffHandle tiff = open(source, name);
    const auto fail = [&](const std::string& what) {
        return FileError(name, "", "TIFF: " + (source.message.empty() ? what : source.message));
    };
    if (!tiff) throw fail("cannot be read");
    const TiffLayout layout = layout_of(tiff.get());
    check_image_size(name, bytes.size(), layout.width, layout.height,
                     std::max<std::uint64_t>(layout.samples, 1));
    if (layout.bits > 16 || layout.format != SAMPLEFORMAT_UINT)
        throw FileError(name, "",
                        "TIFF: expected unsigned samples of up to 16 bits, found " +
                            std::to_string(layout.bits) + " bits of sample format " +
                            std::to_string(layout.format));
    const bool grey = layout.photometric == PHOTOMETRIC_MINISBLACK ||
                      layout.photometric == PHOTOMETRIC_MINISWHITE;
    const bool plain = layout.planar == PLANARCONFIG_CONTIG && !TIFFIsTiled(tiff.get()) &&
                       (layout.bits == 8 || layout.bits == 16) &&
                       ((grey && layout.samples >= 1) ||
                        (layout.photometric == PHOTOMETRIC_RGB && layout.samples >= 3));
    if (layout.bits > 8 && !plain)
        throw FileError(name, "",
                        "TIFF: " + std::to_string(layout.bits) +
                            "-bit samples: expected 16 bits, grey or RGB, in strips with "
                            "the channels interleaved");
    LoadedImage loaded;
    loaded.bits = layout.bits == 16 ? 16 : 8;
    loaded.pixels = Image<std::uint16_t>(static_cast<int>(layout.width),
                                         static_cast<int>(layout.height), grey ? 1 : 3);
    const bool done = plain ? read_samples(tiff.get(), layout, loaded)
                            : read_converted(tiff.get(), layout, loaded);
    if (!done) throw fail("the pixels cannot be decoded");
    return loaded;
}

}  // namespace stria
