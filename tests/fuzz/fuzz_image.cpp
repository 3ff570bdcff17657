// A PNG, JPEG or TIFF.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "host/core/errors.h"
#include "host/io/image_io.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        (void)stria::parse_image({reinterpret_cast<const char*>(data), size}, "input");
    } catch (const stria::Error&) {
    }
    return 0;
}
