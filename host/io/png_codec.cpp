#include <png.h>

#include <cstring>
#include <memory>
#include <vector>

#include "host/core/errors.h"
#include "host/io/image_codecs.h"

// libpng reports errors by longjmp. Every function that calls setjmp here has only trivial locals
// and owns nothing, so that no destructor is jumped over; memory belongs to the callers.
namespace stria {
namespace {

struct PngSource {
    png_structp png = nullptr;
    png_infop info = nullptr;
    const unsigned char* next = nullptr;
    std::size_t left = 0;
    char message[160] = "";
};

void on_error(png_structp png, png_const_charp message) {
    auto* text = static_cast<char*>(png_get_error_ptr(png));
    std::strncpy(text, message, 159);
    png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

void on_read(png_structp png, png_bytep out, size_t count) {
    auto* source = static_cast<PngSource*>(png_get_io_ptr(png));
    if (count > source->left) png_error(png, "the file ends too early");
    std::memcpy(out, source->next, count);
    source->next += count;
    source->left -= count;
}

/// Header and transformations: afterwards rows hold 1 or 3 channels of 8 or 16 bits.
bool read_header(PngSource* source) {
    if (setjmp(png_jmpbuf(source->png))) return false;
    png_set_read_fn(source->png, source, on_read);
    png_set_user_limits(source->png, 32768, 32768);
    png_set_chunk_malloc_max(source->png, 8U << 20);
    png_read_info(source->png, source->info);
    const int colour = png_get_color_type(source->png, source->info);
    const int depth = png_get_bit_depth(source->png, source->info);
    if (colour == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(source->png);
    if (colour == PNG_COLOR_TYPE_GRAY && depth < 8) png_set_expand_gray_1_2_4_to_8(source->png);
    png_set_strip_alpha(source->png);
    if (depth == 16) png_set_swap(source->png);
    png_set_interlace_handling(source->png);
    png_read_update_info(source->png, source->info);
    return true;
}

bool read_rows(PngSource* source, png_bytepp rows) {
    if (setjmp(png_jmpbuf(source->png))) return false;
    png_read_image(source->png, rows);
    png_read_end(source->png, nullptr);
    return true;
}

struct PngReader {
    PngSource source;
    PngReader() {
        source.png =
            png_create_read_struct(PNG_LIBPNG_VER_STRING, source.message, on_error, on_warning);
        if (source.png) source.info = png_create_info_struct(source.png);
    }
    ~PngReader() { png_destroy_read_struct(&source.png, &source.info, nullptr); }
    PngReader(const PngReader&) = delete;
    PngReader& operator=(const PngReader&) = delete;
};

struct PngSink {
    std::string bytes;
    bool out_of_memory = false;
};

void on_write(png_structp png, png_bytep data, size_t count) {
    auto* sink = static_cast<PngSink*>(png_get_io_ptr(png));
    try {
        sink->bytes.append(reinterpret_cast<const char*>(data), count);
    } catch (const std::exception&) {
        sink->out_of_memory = true;
    }
    if (sink->out_of_memory) png_error(png, "out of memory");
}

void on_flush(png_structp) {}

bool write_rows(png_structp png, png_infop info, PngSink* sink, png_bytepp rows, unsigned width,
                unsigned height, int bits, int colour) {
    if (setjmp(png_jmpbuf(png))) return false;
    png_set_write_fn(png, sink, on_write, on_flush);
    png_set_IHDR(png, info, width, height, bits, colour, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png, 4);  // near the size of 6 in half its time
    png_write_info(png, info);
    if (bits == 16) png_set_swap(png);
    png_write_image(png, rows);
    png_write_end(png, nullptr);
    return true;
}

template <typename T>
std::string encode(const Image<T>& image) {
    if (image.width < 1 || image.height < 1 || (image.channels != 1 && image.channels != 3))
        throw Error("PNG: expected an image of 1 or 3 channels, found " +
                    std::to_string(image.width) + " x " + std::to_string(image.height) + " x " +
                    std::to_string(image.channels));
    char message[160] = "";
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, message, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    PngSink sink;
    bool done = false;
    if (info) {
        std::vector<png_bytep> rows(static_cast<std::size_t>(image.height));
        auto* values = const_cast<T*>(image.values.data());  // libpng does not write to it
        for (int y = 0; y < image.height; ++y)
            rows[static_cast<std::size_t>(y)] =
                reinterpret_cast<png_bytep>(values + image.index(0, y));
        done = write_rows(png, info, &sink, rows.data(), static_cast<unsigned>(image.width),
                          static_cast<unsigned>(image.height), 8 * static_cast<int>(sizeof(T)),
                          image.channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB);
    }
    png_destroy_write_struct(&png, &info);
    if (!done) throw Error(std::string("PNG: cannot encode: ") + message);
    return std::move(sink.bytes);
}

}  // namespace

LoadedImage decode_png(std::string_view bytes, const std::string& name) {
    PngReader reader;
    PngSource& source = reader.source;
    if (!source.info) throw FileError(name, "", "PNG: out of memory");
    source.next = reinterpret_cast<const unsigned char*>(bytes.data());
    source.left = bytes.size();
    const auto fail = [&] {
        return FileError(name, "byte " + std::to_string(bytes.size() - source.left),
                         std::string("PNG: ") + source.message);
    };
    if (!read_header(&source)) throw fail();
    const auto width = png_get_image_width(source.png, source.info);
    const auto height = png_get_image_height(source.png, source.info);
    const int channels = png_get_channels(source.png, source.info);
    const int bits = png_get_bit_depth(source.png, source.info);
    check_image_size(name, bytes.size(), width, height, static_cast<std::uint64_t>(channels));
    const std::size_t row_bytes = png_get_rowbytes(source.png, source.info);
    const std::size_t samples = std::size_t{width} * static_cast<std::size_t>(channels);
    if ((channels != 1 && channels != 3) || (bits != 8 && bits != 16) ||
        row_bytes != samples * static_cast<std::size_t>(bits / 8))
        throw FileError(name, "", "PNG: this combination of colour and depth is not supported");

    LoadedImage loaded;
    loaded.bits = bits;
    loaded.pixels =
        Image<std::uint16_t>(static_cast<int>(width), static_cast<int>(height), channels);
    std::vector<std::uint8_t> narrow(bits == 8 ? row_bytes * height : 0);
    std::vector<png_bytep> rows(height);
    auto* base =
        bits == 8 ? narrow.data() : reinterpret_cast<std::uint8_t*>(loaded.pixels.values.data());
    for (std::size_t y = 0; y < height; ++y) rows[y] = base + y * row_bytes;
    if (!read_rows(&source, rows.data())) throw fail();
    if (bits == 8) std::copy(narrow.begin(), narrow.end(), loaded.pixels.values.begin());
    return loaded;
}

std::string encode_png(const Image<std::uint8_t>& image) { return encode(image); }
std::string encode_png(const Grey16Image& image) { return encode(image); }

}  // namespace stria
