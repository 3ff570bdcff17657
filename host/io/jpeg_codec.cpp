#include <cstdio>
// jpeglib.h needs the line above
#include <jpeglib.h>
// and jerror.h needs jpeglib.h
#include <jerror.h>
#include <setjmp.h>

#include <vector>

#include "host/core/errors.h"
#include "host/io/image_codecs.h"

// libjpeg reports errors by our longjmp. Functions that call setjmp have only trivial locals and
// own nothing; memory belongs to the caller.
namespace stria {
namespace {

constexpr int kMostScans = 200;  ///< of a progressive file; more are an attack on our time

struct JpegSource {
    jpeg_decompress_struct info{};
    jpeg_error_mgr errors{};
    jpeg_progress_mgr progress{};
    jmp_buf escape{};
    char message[JMSG_LENGTH_MAX] = "";
};

JpegSource* source_of(j_common_ptr info) { return static_cast<JpegSource*>(info->client_data); }

void on_error(j_common_ptr info) {
    JpegSource* source = source_of(info);
    info->err->format_message(info, source->message);
    longjmp(source->escape, 1);
}

/// Warnings that mean lost pixels are errors: a truncated photograph is not a photograph.
void on_message(j_common_ptr info, int level) {
    if (level >= 0) return;
    switch (info->err->msg_code) {
        case JWRN_JPEG_EOF:
        case JWRN_HIT_MARKER:
        case JWRN_HUFF_BAD_CODE:
        case JWRN_MUST_RESYNC:
        case JWRN_BOGUS_PROGRESSION:
        case JWRN_ARITH_BAD_CODE:
            on_error(info);
            break;
        default:
            break;
    }
}

void on_progress(j_common_ptr info) {
    if (!info->is_decompressor) return;
    if (reinterpret_cast<j_decompress_ptr>(info)->input_scan_number > kMostScans)
        ERREXIT(info, JERR_BAD_PROGRESSION);
}

bool read_header(JpegSource* source, const unsigned char* bytes, unsigned long count) {
    if (setjmp(source->escape)) return false;
    jpeg_mem_src(&source->info, bytes, count);
    jpeg_read_header(&source->info, TRUE);
    source->info.out_color_space =
        source->info.jpeg_color_space == JCS_GRAYSCALE ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_calc_output_dimensions(&source->info);
    return true;
}

/// `row` holds one row; every row is widened into `pixels`.
bool read_rows(JpegSource* source, JSAMPLE* row, std::uint16_t* pixels) {
    if (setjmp(source->escape)) return false;
    jpeg_start_decompress(&source->info);
    const std::size_t samples = std::size_t{source->info.output_width} *
                                static_cast<std::size_t>(source->info.output_components);
    while (source->info.output_scanline < source->info.output_height) {
        std::uint16_t* out = pixels + source->info.output_scanline * samples;
        jpeg_read_scanlines(&source->info, &row, 1);
        for (std::size_t i = 0; i < samples; ++i) out[i] = row[i];
    }
    jpeg_finish_decompress(&source->info);
    return true;
}

bool create(JpegSource* source) {
    source->info.err = jpeg_std_error(&source->errors);
    source->errors.error_exit = on_error;
    source->errors.emit_message = on_message;
    source->info.client_data = source;
    if (setjmp(source->escape)) return false;
    jpeg_create_decompress(&source->info);  // keeps err and client_data
    source->info.mem->max_memory_to_use = 256L << 20;
    source->progress.progress_monitor = on_progress;
    source->info.progress = &source->progress;
    return true;
}

struct JpegReader {
    JpegSource source;
    bool ok = create(&source);
    ~JpegReader() { jpeg_destroy_decompress(&source.info); }
};

}  // namespace

LoadedImage decode_jpeg(std::string_view bytes, const std::string& name) {
    JpegReader reader;
    JpegSource& source = reader.source;
    const auto fail = [&] {
        const std::size_t left = source.info.src ? source.info.src->bytes_in_buffer : bytes.size();
        return FileError(name,
                         "byte " + std::to_string(bytes.size() - std::min(left, bytes.size())),
                         std::string("JPEG: ") + source.message);
    };
    if (!reader.ok ||
        !read_header(&source, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()))
        throw fail();
    const int channels = source.info.out_color_space == JCS_GRAYSCALE ? 1 : 3;
    check_image_size(name, bytes.size(), source.info.output_width, source.info.output_height,
                     static_cast<std::uint64_t>(channels));
    LoadedImage loaded;
    loaded.bits = 8;
    loaded.pixels = Image<std::uint16_t>(static_cast<int>(source.info.output_width),
                                         static_cast<int>(source.info.output_height), channels);
    std::vector<JSAMPLE> row(std::size_t{source.info.output_width} *
                             static_cast<std::size_t>(channels));
    if (!read_rows(&source, row.data(), loaded.pixels.values.data())) throw fail();
    return loaded;
}

}  // namespace stria
