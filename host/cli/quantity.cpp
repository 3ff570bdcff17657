#include "host/cli/quantity.h"

#include <charconv>
#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

#include "firmware/core/angle.h"

namespace stria {
namespace {

using Units = std::vector<std::pair<std::string, double>>;  // the first where none is stated

const Units kLengths_mm = {{"mm", 1}, {"um", 1e-3}, {"cm", 10}, {"m", 1000}, {"in", 25.4}};

Units scaled(Units units, double factor, const std::string& first) {
    for (auto& [name, value] : units) value *= factor;
    for (std::size_t i = 0; i < units.size(); ++i)
        if (units[i].first == first) std::swap(units[0], units[i]);
    return units;
}

Units units_of(Quantity quantity) {
    switch (quantity) {
        case Quantity::number:
            return {};
        case Quantity::length_mm:
            return kLengths_mm;
        case Quantity::pitch_um:
            return scaled(kLengths_mm, 1000, "um");
        case Quantity::wavelength_nm:
            return {{"nm", 1}, {"um", 1000}};
        case Quantity::angle_rad:
            return {{"deg", kDegree}, {"rad", 1}, {"mrad", 1e-3}};
        case Quantity::time_us:
            return {{"us", 1}, {"ms", 1e3}, {"s", 1e6}};
        case Quantity::power_mw:
            return {{"mW", 1}, {"uW", 1e-3}, {"W", 1000}};
        case Quantity::position: {
            Units units = kLengths_mm;
            for (const auto& unit : units_of(Quantity::angle_rad)) units.push_back(unit);
            return units;
        }
    }
    return {};
}

[[noreturn]] void refuse(const std::string& option, const std::string& text, const Units& units) {
    std::string expected = "a finite number";
    for (std::size_t i = 0; i < units.size(); ++i)
        expected += (i == 0 ? ", its unit one of " : ", ") + units[i].first;
    throw std::invalid_argument(option + " '" + text + "': expected " + expected);
}

}  // namespace

double parse_quantity(const std::string& option, const std::string& text, Quantity quantity,
                      double mm_per_unit) {
    const Units units = units_of(quantity);
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || !std::isfinite(value)) refuse(option, text, units);
    std::string unit(rest, end);
    unit.erase(0, unit.find_first_not_of(' ') == std::string::npos ? unit.size()
                                                                   : unit.find_first_not_of(' '));
    if (unit.empty()) {
        if (quantity == Quantity::length_mm) return value * mm_per_unit;
        return units.empty() || quantity == Quantity::position ? value
                                                               : value * units.front().second;
    }
    for (const auto& [name, factor] : units)
        if (name == unit) return value * factor;
    refuse(option, text, units);
}

}  // namespace stria
