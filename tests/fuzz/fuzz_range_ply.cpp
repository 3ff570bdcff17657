// A range PLY. What is read must be whole, and be written and read again with the same points.
#include "host/io/range_io.h"
#include "tests/fuzz/fuzz_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stria;
    return read_or_refuse([&] {
        const RangeImage image = parse_range_image(text_of(data, size), "input.ply");
        require(image.points.size() == image.cell_count());
        require(image.sensitivity.size() ==
                image.cell_count() * static_cast<std::size_t>(image.sensitivity_count));
        for (const FurtherReturn& further : image.further)
            require(further.cell < image.cell_count() && image.mask[further.cell] == 1);
        const RangeImage back = parse_range_image(format_range_image(image), "written.ply");
        require(back.mask == image.mask && back.further.size() == image.further.size());
    });
}
