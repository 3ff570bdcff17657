#include "host/io/mesh_formats.h"

namespace stria {

// A stream of runs: a control byte below 32 is followed by that many literal bytes plus one;
// otherwise its upper three bits are a length (7: one more byte of it follows) and the other five,
// with the next byte, a distance back into what has been written.
std::string lzf_decompress(std::string_view compressed, std::size_t size) {
    std::string out;
    out.reserve(size);
    std::size_t at = 0;
    const auto next = [&]() -> std::size_t { return static_cast<std::uint8_t>(compressed[at++]); };
    while (at < compressed.size()) {
        const std::size_t control = next();
        if (control < 32) {
            const std::size_t count = control + 1;
            if (count > compressed.size() - at || count > size - out.size()) return "";
            out.append(compressed.substr(at, count));
            at += count;
            continue;
        }
        std::size_t length = (control >> 5) + 2;
        if (at + (length == 9 ? 2U : 1U) > compressed.size()) return "";
        if (length == 9) length += next();
        const std::size_t distance = ((control & 31) << 8) + next() + 1;
        if (distance > out.size() || length > size - out.size()) return "";
        for (std::size_t from = out.size() - distance; length > 0; --length) out += out[from++];
    }
    return out.size() == size ? out : "";
}

}  // namespace stria
