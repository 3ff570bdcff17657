// A payload of the wire: the first byte is its type, the rest goes to decode(). What decodes must
// encode to something that decodes again.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <variant>
#include <vector>

#include "firmware/protocol/codec.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const auto type = static_cast<stria::MessageType>(data[0]);
    const std::vector<std::uint8_t> payload(data + 1, data + size);  // aligned as the wire's
    const auto message = stria::decode(type, payload);
    if (!message.ok()) return 0;
    const stria::Bytes again =
        std::visit([](const auto& value) { return stria::encode(value); }, message.value());
    if (!stria::decode(type, again).ok()) std::abort();
    return 0;
}
