#pragma once
#include <string>
#include <vector>

#include "host/render/colour_map.h"

namespace stria {

/// One axis of a plot: "depth" with unit "mm" is titled "depth (mm)".
struct PlotAxis {
    std::string label;
    std::string unit;
    bool logarithmic = false;  ///< values that are not positive are left out
    bool whole = false;        ///< ticks at whole numbers only: what is counted
    bool with_zero = false;    ///< zero is in view whatever the values are
};

struct PlotSeries {
    std::string name;  ///< in the legend above the frame; empty: none
    std::vector<double> x, y;
    bool points = false;  ///< dots instead of a line
};

struct LinePlot {
    PlotAxis x, y;
    std::vector<PlotSeries> series;
    int width = 560;
    int height = 320;
};

/// The plot as an SVG element, text and axes in `currentColor` so that it suits light and dark
/// pages. Values that are not finite interrupt the line.
std::string line_plot_svg(const LinePlot& plot);

struct Histogram {
    PlotAxis x;
    std::string y_label = "share (%)";
    std::vector<double> values;
    double low = 0, high = 0;  ///< range of the bins; both 0: that of the values
    int bins = 60;
    /// Normal distribution drawn over it; sigma 0: none.
    double normal_mean = 0, normal_sigma = 0;
    std::string normal_name = "predicted";
    int width = 560;
    int height = 280;
};

/// As an SVG element. Values outside the range are counted in a note below.
std::string histogram_svg(const Histogram& histogram);

/// Colour bar with ticks and its title, as an SVG element.
std::string colour_bar_svg(const ColourScale& scale, int width = 360);

}  // namespace stria
