#include <cstdint>
#include <fstream>
#include <string>
#include <variant>

#include "firmware/protocol/codec.h"
#include "firmware/protocol/framing.h"
#include "tests/firmware/protocol/samples.h"
#include "tests/fuzz/write_seed.h"

namespace stria {
namespace {

std::string text_of(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

}  // namespace

void write_seed(const std::filesystem::path& file, std::string_view bytes) {
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

void write_wire_seeds(const std::filesystem::path& corpus) {
    std::string stream;
    std::uint32_t sequence = 0;
    for (const Message& message : samples::all()) {
        const Bytes payload = std::visit([](const auto& value) { return encode(value); }, message);
        const MessageType type = type_of(message);
        const std::string name =
            "type_" + std::to_string(static_cast<int>(type)) + "_" + std::to_string(sequence);
        write_seed(corpus / "fuzz_message" / name, static_cast<char>(type) + text_of(payload));
        const RawMessage raw = make_raw(WireChannel::data, type, payload, 1, sequence++);
        const auto header = encode_header(raw.header);
        const std::string framed = std::string(header.begin(), header.end()) + text_of(payload);
        if (payload.size() < 400) write_seed(corpus / "fuzz_framing" / name, framed);
        stream += framed;
    }
    write_seed(corpus / "fuzz_framing" / "stream", stream);
    write_seed(corpus / "fuzz_framing" / "torn", stream.substr(0, stream.size() - 7));
}

}  // namespace stria
