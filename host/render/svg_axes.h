#pragma once
#include <string>
#include <vector>

#include "host/render/plot.h"

namespace stria {

/// Range of one axis in values and in pixels of the drawing.
struct AxisSpan {
    double low = 0, high = 1;  ///< values, low < high
    bool logarithmic = false;
    double from_px = 0, to_px = 1;
    bool whole = false;  ///< ticks at whole numbers only

    /// Pixel of a value; not finite for values a logarithmic axis cannot show.
    double at(double value) const;
};

/// Values for ticks: 1, 2, 5 times powers of ten, about `wanted` of them; powers of ten on a
/// logarithmic axis.
std::vector<double> tick_values(const AxisSpan& span, int wanted);

/// A tick's number, short: "0.02", "1e-05".
std::string tick_text(double value);

/// "label (unit)".
std::string axis_title(const PlotAxis& axis);

/// Text with & < > " escaped.
std::string escape_markup(const std::string& text);

/// Frame, grid lines, ticks and titles of a plot.
std::string svg_axes(const AxisSpan& x, const AxisSpan& y, const std::string& x_title,
                     const std::string& y_title);

/// Opening tag of a drawing of that size in user units, which shrinks with the page.
std::string svg_open(int width, int height);

/// A number with two decimals, for coordinates.
std::string svg_number(double value);

/// Colour of the i-th series: tells itself from the others on light and on dark.
std::string series_colour(std::size_t i);

}  // namespace stria
