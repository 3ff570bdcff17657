#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "firmware/protocol/messages.h"

namespace stria {

/// The map cut into bands of whole rows, each of at most `max_bytes` before packing (one row at
/// least), so that a message stays within its limit and a torn recording loses little.
std::vector<PulseBand> split_into_bands(const PulseMap& map,
                                        std::size_t max_bytes = std::size_t{1} << 20);

/// Puts bands back together, one map after the other.
class PulseMapAssembler {
  public:
    /// The whole map with its last band, empty before. A band that begins another map while one is
    /// unfinished gives up the rest of that one: see unfinished().
    std::optional<PulseMap> add(PulseBand band);

    /// What has come of a map whose last bands are missing: its lost rows are empty.
    std::optional<PulseMap> unfinished();

    bool is_empty() const { return bands_.empty(); }

  private:
    std::vector<PulseBand> bands_;
};

}  // namespace stria
