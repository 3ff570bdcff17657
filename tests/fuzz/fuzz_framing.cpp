// A stream of framed messages, as a socket or a recording delivers them, read until it breaks off.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "firmware/protocol/codec.h"
#include "firmware/protocol/framing.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::span<const std::uint8_t> rest(data, size);
    while (rest.size() >= stria::kHeaderBytes) {
        const auto header = stria::decode_header(rest.first<stria::kHeaderBytes>());
        if (!header.ok()) return 0;
        rest = rest.subspan(stria::kHeaderBytes);
        const std::size_t length = std::min<std::size_t>(rest.size(), header.value().length);
        const std::vector<std::uint8_t> payload(rest.begin(),
                                                rest.begin() + static_cast<std::ptrdiff_t>(length));
        if (stria::check_payload(header.value(), payload).ok()) {
            (void)stria::decode(header.value().type, payload);
        }
        rest = rest.subspan(length);
    }
    return 0;
}
