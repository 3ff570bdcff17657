#pragma once
#include <string>

namespace stria {

/// What an option's number is, and the unit it comes back in.
enum class Quantity {
    number,         ///< no unit
    length_mm,      ///< um, mm, cm, m, in
    pitch_um,       ///< the same, um where none is stated
    wavelength_nm,  ///< nm, um
    angle_rad,      ///< deg, rad, mrad; degrees where none is stated
    time_us,        ///< us, ms, s
    power_mw,       ///< uW, mW, W
    position,       ///< mm, um, cm, m, in; rad, mrad, deg: unit of s, as stated where none is
};

/// Number with an optional unit ("0.3mm", "25 deg", "400"). Throws std::invalid_argument naming
/// option, text and the units it takes, where it is no number, not finite, or of another unit.
/// @param mm_per_unit  of a length without a unit
double parse_quantity(const std::string& option, const std::string& text, Quantity quantity,
                      double mm_per_unit = 1);

}  // namespace stria
