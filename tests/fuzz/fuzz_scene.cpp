// scene.toml, the simulator's input; files that it names are not there.
#include <cstddef>
#include <cstdint>
#include <string>

#include "host/core/errors.h"
#include "sim/scene.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        (void)stria::parse_scene({reinterpret_cast<const char*>(data), size}, "scene.toml",
                                 "/nonexistent");
    } catch (const stria::Error&) {
    }
    return 0;
}
