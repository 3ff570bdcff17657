#include "firmware/protocol/pulse_bands.h"

#include <utility>

namespace stria {
namespace {

PulseMap without_cells(const PulseMap& map) {
    PulseMap head;
    head.mode = map.mode;
    head.width = map.width;
    head.height = map.height;
    head.camera_id = map.camera_id;
    head.frames = map.frames;
    head.frames_dropped = map.frames_dropped;
    head.saturated_samples = map.saturated_samples;
    head.undersampled = map.undersampled;
    return head;
}

PulseBand band_of(const PulseMap& map, int first, int last) {
    const auto width = static_cast<std::size_t>(map.width);
    const std::size_t begin = static_cast<std::size_t>(first) * width;
    const std::size_t end = static_cast<std::size_t>(last) * width;
    PulseBand band{without_cells(map), first, map.height};
    band.map.height = last - first;
    const std::uint32_t offset = map.cell_begin[begin];
    band.map.cell_begin.reserve(end - begin + 1);
    for (std::size_t i = begin; i <= end; ++i)
        band.map.cell_begin.push_back(map.cell_begin[i] - offset);
    band.map.pulses.assign(map.pulses.begin() + offset, map.pulses.begin() + map.cell_begin[end]);
    return band;
}

PulseMap joined(std::vector<PulseBand>& bands) {
    PulseMap map = without_cells(bands.front().map);
    map.height = bands.front().full_height;
    const std::size_t cells =
        static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height);
    map.cell_begin.reserve(cells + 1);
    map.cell_begin.push_back(0);
    for (const PulseBand& band : bands) {
        const auto offset = static_cast<std::uint32_t>(map.pulses.size());
        for (std::size_t i = 1; i < band.map.cell_begin.size(); ++i)
            map.cell_begin.push_back(band.map.cell_begin[i] + offset);
        map.pulses.insert(map.pulses.end(), band.map.pulses.begin(), band.map.pulses.end());
    }
    map.cell_begin.resize(cells + 1, static_cast<std::uint32_t>(map.pulses.size()));
    bands.clear();
    return map;
}

}  // namespace

std::vector<PulseBand> split_into_bands(const PulseMap& map, std::size_t max_bytes) {
    const auto width = static_cast<std::size_t>(map.width);
    const auto bytes_up_to = [&](int row) {
        const std::size_t cell = static_cast<std::size_t>(row) * width;
        return cell + map.cell_begin[cell] * sizeof(Pulse);
    };
    std::vector<PulseBand> bands;
    int first = 0;
    for (int row = 1; row <= map.height; ++row) {
        const bool is_last = row == map.height;
        if (!is_last && bytes_up_to(row + 1) - bytes_up_to(first) <= max_bytes) continue;
        bands.push_back(band_of(map, first, row));
        first = row;
    }
    return bands;
}

std::optional<PulseMap> PulseMapAssembler::add(PulseBand band) {
    const int last = band.first_row + band.map.height;
    const int next = bands_.empty() ? 0 : bands_.back().first_row + bands_.back().map.height;
    const bool follows = !bands_.empty() && band.first_row == next &&
                         band.full_height == bands_.front().full_height &&
                         band.map.width == bands_.front().map.width;
    if (!follows) bands_.clear();
    if (!follows && band.first_row != 0) return std::nullopt;  // its beginning was lost
    const bool is_last = last == band.full_height;
    bands_.push_back(std::move(band));
    if (!is_last) return std::nullopt;
    return joined(bands_);
}

std::optional<PulseMap> PulseMapAssembler::unfinished() {
    if (bands_.empty()) return std::nullopt;
    return joined(bands_);
}

}  // namespace stria
