// A range PLY. What is read must be written and read again with the same points.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "host/core/errors.h"
#include "host/io/range_io.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        const stria::RangeImage image =
            stria::parse_range_image({reinterpret_cast<const char*>(data), size}, "input");
        const stria::RangeImage again =
            stria::parse_range_image(stria::format_range_image(image), "again");
        if (again.width != image.width || again.height != image.height) std::abort();
    } catch (const stria::Error&) {
    }
    return 0;
}
