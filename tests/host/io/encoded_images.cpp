#include "tests/host/io/encoded_images.h"

#include <cstdio>
// jpeglib.h needs the line above
#include <jpeglib.h>
#include <tiffio.h>

#include <cstdlib>

#include "host/io/whole_file.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {

std::string encode_jpeg(const Image<std::uint8_t>& image, int quality) {
    jpeg_compress_struct info{};
    jpeg_error_mgr errors{};
    info.err = jpeg_std_error(&errors);
    jpeg_create_compress(&info);
    unsigned char* bytes = nullptr;
    unsigned long count = 0;
    jpeg_mem_dest(&info, &bytes, &count);
    info.image_width = static_cast<unsigned>(image.width);
    info.image_height = static_cast<unsigned>(image.height);
    info.input_components = image.channels;
    info.in_color_space = image.channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_set_defaults(&info);
    jpeg_set_quality(&info, quality, TRUE);
    jpeg_start_compress(&info, TRUE);
    for (int y = 0; y < image.height; ++y) {
        auto* row = const_cast<JSAMPLE*>(&image.values[image.index(0, y)]);
        jpeg_write_scanlines(&info, &row, 1);
    }
    jpeg_finish_compress(&info);
    jpeg_destroy_compress(&info);
    std::string result(reinterpret_cast<char*>(bytes), count);
    std::free(bytes);
    return result;
}

namespace {

template <typename T>
std::string encode(const Image<T>& image, int compression) {
    const TemporaryFolder folder;
    TIFF* tiff = TIFFOpen((folder / "a.tif").c_str(), "w");
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, image.width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, image.height);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8 * static_cast<int>(sizeof(T)));
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, image.channels);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
                 image.channels == 1 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, compression);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 4);
    for (int y = 0; y < image.height; ++y)
        TIFFWriteScanline(tiff, const_cast<T*>(&image.values[image.index(0, y)]),
                          static_cast<std::uint32_t>(y));
    TIFFClose(tiff);
    return read_whole_file(folder / "a.tif");
}

}  // namespace

std::string encode_tiff(const Image<std::uint8_t>& image, int compression) {
    return encode(image, compression);
}
std::string encode_tiff(const Image<std::uint16_t>& image, int compression) {
    return encode(image, compression);
}

}  // namespace stria
