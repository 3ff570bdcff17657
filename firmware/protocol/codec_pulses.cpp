#include <cstring>

#include "firmware/protocol/compress.h"
#include "firmware/protocol/validate.h"
#include "firmware/protocol/wire.h"

/// A band's numbers travel as columns (all u, all v, ...), each with its bytes sorted by
/// significance: neighbouring pulses share their high bytes, which zstd then packs well.
namespace stria {
namespace wire_format {
namespace {

/// Calls visit(member) for every column of a pulse, in wire order.
template <typename P, typename Visit>
void for_each_member(P& pulse, Visit visit) {
    visit(pulse.u);
    visit(pulse.v);
    visit(pulse.t_ns);
    visit(pulse.s);
    visit(pulse.ds_dt);
    visit(pulse.amplitude);
    visit(pulse.width);
    visit(pulse.background);
    visit(pulse.sigma);
    visit(pulse.chi_square);
    visit(pulse.flags);
    visit(pulse.laser_id);
    visit(pulse.exposure_index);
}

std::size_t bytes_per_pulse() {
    std::size_t size = 0;
    Pulse pulse;
    for_each_member(pulse, [&](const auto& member) { size += sizeof member; });
    return size;
}

/// Columns start at a multiple of `count` times the bytes before them; byte j of value i of a
/// column lies at j * count + i within it.
Bytes columns_of(const PulseMap& map) {
    const std::size_t cells = map.cell_begin.size() - 1;
    const std::size_t count = map.pulses.size();
    Bytes out(cells + count * bytes_per_pulse());
    for (std::size_t i = 0; i < cells; ++i)
        out[i] = static_cast<std::uint8_t>(map.cell_begin[i + 1] - map.cell_begin[i]);
    for (std::size_t i = 0; i < count; ++i) {
        std::uint8_t* column = out.data() + cells;
        for_each_member(map.pulses[i], [&](const auto& member) {
            std::uint8_t bytes[sizeof member];
            std::memcpy(bytes, &member, sizeof member);
            for (std::size_t j = 0; j < sizeof member; ++j) column[j * count + i] = bytes[j];
            column += sizeof member * count;
        });
    }
    return out;
}

/// False if the cells do not hold `count` pulses.
bool read_columns(const Bytes& in, std::size_t cells, std::size_t count, PulseMap& map) {
    map.cell_begin.assign(cells + 1, 0);
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < cells; ++i) {
        sum += in[i];
        map.cell_begin[i + 1] = static_cast<std::uint32_t>(sum);
    }
    if (sum != count) return false;
    map.pulses.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint8_t* column = in.data() + cells;
        for_each_member(map.pulses[i], [&](auto& member) {
            std::uint8_t bytes[sizeof member];
            for (std::size_t j = 0; j < sizeof member; ++j) bytes[j] = column[j * count + i];
            std::memcpy(&member, bytes, sizeof member);
            column += sizeof member * count;
        });
    }
    return true;
}

}  // namespace

Result<Message> decode_pulse_band(std::span<const std::uint8_t> payload) {
    const auto* root = verified_root<wire::PulseBand>(payload);
    if (root == nullptr || root->columns() == nullptr) return malformed("pulse map");
    const int width = root->width(), rows = root->rows();
    if (width < 1 || width > kMaxMapWidth || rows < 1 || rows > kMaxFrameSide)
        return Failure{"pulse map: expected 1 to 1000000 x 1 to 16384 cells, found " +
                       std::to_string(width) + " x " + std::to_string(rows)};
    const std::size_t cells = static_cast<std::size_t>(width) * static_cast<std::size_t>(rows);
    const std::size_t size = cells + root->pulses() * bytes_per_pulse();
    if (size > kMaxPayloadBytes) return Failure{"pulse map: expected at most 64 MiB in a band"};
    const auto columns =
        unpack(root->compression(), {root->columns()->data(), root->columns()->size()}, size);
    if (!columns) return Failure{"pulse map: " + columns.failure().message};
    PulseBand band;
    band.first_row = root->first_row();
    band.full_height = root->full_height();
    band.map.mode = static_cast<StripeMode>(root->mode());
    band.map.camera_id = root->camera_id();
    band.map.width = width;
    band.map.height = rows;
    band.map.frames = root->frames();
    band.map.frames_dropped = root->frames_dropped();
    band.map.saturated_samples = root->saturated_samples();
    band.map.undersampled = root->undersampled();
    if (!read_columns(*columns, cells, root->pulses(), band.map))
        return Failure{"pulse map: the cells do not hold as many pulses as it says"};
    const std::string complaint = validate(band);
    return checked("pulse map", std::move(band), complaint);
}

}  // namespace wire_format

Bytes encode(const PulseBand& band) {
    const Packed packed = pack(wire_format::columns_of(band.map));
    wire_format::Builder b(packed.bytes.size() + 256);
    const auto columns = b.CreateVector(packed.bytes);
    const PulseMap& map = band.map;
    b.Finish(wire::CreatePulseBand(b, static_cast<std::uint8_t>(map.mode), map.camera_id, map.width,
                                   band.full_height, band.first_row, map.height, map.frames,
                                   map.frames_dropped, map.saturated_samples, map.undersampled,
                                   static_cast<std::uint32_t>(map.pulses.size()),
                                   static_cast<std::uint8_t>(packed.compression), columns));
    return wire_format::finished(b);
}

}  // namespace stria
