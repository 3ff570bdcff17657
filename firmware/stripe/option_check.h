#pragma once
#include <stdexcept>
#include <string>

namespace stria {

/// Refuses options out of bounds: `const OptionCheck require{"PathOptions"}`, then
/// `require(threads >= 1, "threads", threads, "1 or more")`.
struct OptionCheck {
    const char* options;

    /// Throws std::invalid_argument, which names options, field, value and bound, unless `holds`.
    void operator()(bool holds, const char* field, double value, const char* bound) const {
        if (!holds)
            throw std::invalid_argument(std::string(options) + "." + field + " = " +
                                        std::to_string(value) + ": expected " + bound);
    }
};

}  // namespace stria
