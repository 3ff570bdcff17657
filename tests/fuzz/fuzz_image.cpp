// A PNG, JPEG or TIFF. What is read must have the samples its size says.
#include "host/io/image_io.h"
#include "tests/fuzz/fuzz_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stria;
    return read_or_refuse([&] {
        const LoadedImage image = parse_image(text_of(data, size), "input");
        require(image.bits == 8 || image.bits == 16);
        require(image.pixels.channels == 1 || image.pixels.channels == 3);
        require(image.pixels.values.size() ==
                image.pixels.index(0, image.pixels.height - 1) +
                    static_cast<std::size_t>(image.pixels.width * image.pixels.channels));
    });
}
