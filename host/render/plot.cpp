#include "host/render/plot.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host/render/svg_axes.h"

namespace stria {
namespace {

constexpr double kLeft = 72, kRight = 16, kTop = 14, kBottom = 48;

bool can_show(double value, bool logarithmic) {
    return std::isfinite(value) && (!logarithmic || value > 0);
}

/// Span of all values with a little air; 0..1 if there are none.
AxisSpan span_of(const LinePlot& plot, bool of_x) {
    const PlotAxis& axis = of_x ? plot.x : plot.y;
    AxisSpan span;
    span.logarithmic = axis.logarithmic;
    span.whole = axis.whole;
    bool any = false;
    for (const PlotSeries& s : plot.series) {
        for (const double value : of_x ? s.x : s.y) {
            if (!can_show(value, span.logarithmic)) continue;
            span.low = any ? std::min(span.low, value) : value;
            span.high = any ? std::max(span.high, value) : value;
            any = true;
        }
    }
    if (span.logarithmic) {
        if (!any) span.low = 0.1;
        span.low /= 1.15;
        span.high *= 1.15;
        return span;
    }
    if (!of_x && any && span.low > 0 && span.low < 0.5 * span.high) span.low = 0;
    if (axis.with_zero && any) {
        span.low = std::min(span.low, 0.0);
        span.high = std::max(span.high, 0.0);
    }
    const double air = span.high > span.low ? 0.04 * (span.high - span.low)
                                            : std::max(1.0, std::abs(span.high)) * 0.5;
    if (span.low != 0 || span.high <= span.low) span.low -= air;
    span.high += air;
    return span;
}

/// The frame, `above` pixels lower than without a legend.
void place(AxisSpan& x, AxisSpan& y, int width, int height, int above) {
    x.from_px = kLeft;
    x.to_px = width - kRight;
    y.from_px = height + above - kBottom;
    y.to_px = kTop + above;
}

std::string series_svg(const PlotSeries& s, const AxisSpan& x, const AxisSpan& y,
                       const std::string& colour) {
    std::string line, dots;
    bool pen_down = false;
    for (std::size_t i = 0; i < s.x.size(); ++i) {
        if (!can_show(s.x[i], x.logarithmic) || !can_show(s.y[i], y.logarithmic)) {
            pen_down = false;
            continue;
        }
        const std::string px = svg_number(x.at(s.x[i])), py = svg_number(y.at(s.y[i]));
        line += (pen_down ? "L" : "M") + px + " " + py;
        dots += "<circle cx='" + px + "' cy='" + py + "' r='2.5' fill='" + colour + "'/>\n";
        pen_down = true;
    }
    if (s.points) return dots;
    return "<path d='" + line + "' fill='none' stroke='" + colour + "' stroke-width='1.8'/>\n";
}

struct Legend {
    std::string svg;
    int height = 0;  ///< px; 0: no entry has a name
};

/// Names and colours in rows above the frame, where they hide no values.
Legend legend_of(const std::vector<std::pair<std::string, std::string>>& entries, int width) {
    constexpr double kMark = 16, kLetter = 6.8, kGap = 14;  // px; letters as wide as they get
    constexpr int kRow = 16;
    Legend legend;
    double x = kLeft;
    for (const auto& [name, colour] : entries) {
        if (name.empty()) continue;
        const double wide = kMark + kLetter * static_cast<double>(name.size());
        if (legend.height == 0 || x + wide > width - kRight) {
            x = kLeft;
            legend.height += kRow;
        }
        legend.svg += "<rect x='" + svg_number(x) + "' y='" + svg_number(legend.height - 10) +
                      "' width='10' height='10' fill='" + colour + "'/>\n<text x='" +
                      svg_number(x + kMark) + "' y='" + svg_number(legend.height - 1) +
                      "' fill='currentColor'>" + escape_markup(name) + "</text>\n";
        x += wide + kGap;
    }
    return legend;
}

struct Bins {
    std::vector<std::size_t> counts;
    double low = 0, high = 1;
    std::size_t total = 0, below = 0, above = 0;
    double width() const { return (high - low) / static_cast<double>(counts.size()); }
};

Bins count_bins(const Histogram& h) {
    Bins bins;
    bins.low = h.low;
    bins.high = h.high;
    if (h.low == 0 && h.high == 0) {
        bool any = false;
        for (const double v : h.values) {
            if (!std::isfinite(v)) continue;
            bins.low = any ? std::min(bins.low, v) : v;
            bins.high = any ? std::max(bins.high, v) : v;
            any = true;
        }
    }
    if (!(bins.high > bins.low)) bins.high = bins.low + 1;
    bins.counts.assign(static_cast<std::size_t>(std::max(h.bins, 1)), 0);
    for (const double v : h.values) {
        if (!std::isfinite(v)) continue;
        ++bins.total;
        if (v < bins.low)
            ++bins.below;
        else if (v > bins.high)
            ++bins.above;
        else
            ++bins.counts[std::min(static_cast<std::size_t>((v - bins.low) / bins.width()),
                                   bins.counts.size() - 1)];
    }
    return bins;
}

}  // namespace

std::string line_plot_svg(const LinePlot& plot) {
    for (const PlotSeries& s : plot.series)
        if (s.x.size() != s.y.size())
            throw std::invalid_argument("line_plot_svg: series '" + s.name + "' has " +
                                        std::to_string(s.x.size()) + " x and " +
                                        std::to_string(s.y.size()) + " y");
    AxisSpan x = span_of(plot, true), y = span_of(plot, false);
    std::vector<std::pair<std::string, std::string>> entries;
    for (std::size_t i = 0; i < plot.series.size(); ++i)
        entries.emplace_back(plot.series[i].name, series_colour(i));
    const Legend legend = legend_of(entries, plot.width);
    place(x, y, plot.width, plot.height, legend.height);
    std::string out = svg_open(plot.width, plot.height + legend.height);
    out += svg_axes(x, y, axis_title(plot.x), axis_title(plot.y));
    for (std::size_t i = 0; i < plot.series.size(); ++i)
        out += series_svg(plot.series[i], x, y, series_colour(i));
    return out + legend.svg + "</svg>\n";
}

std::string histogram_svg(const Histogram& h) {
    const Bins bins = count_bins(h);
    const double per_count = bins.total > 0 ? 100.0 / static_cast<double>(bins.total) : 0.0;
    const std::size_t most = *std::max_element(bins.counts.begin(), bins.counts.end());
    AxisSpan x{bins.low, bins.high},
        y{0, std::max(1e-9, 1.08 * per_count * static_cast<double>(most))};

    PlotSeries normal{h.normal_name, {}, {}};
    for (int i = 0; h.normal_sigma > 0 && i <= 200; ++i) {
        const double at = x.low + (x.high - x.low) * i / 200;
        const double z = (at - h.normal_mean) / h.normal_sigma;
        normal.x.push_back(at);
        normal.y.push_back(100.0 * bins.width() / (h.normal_sigma * std::sqrt(2 * M_PI)) *
                           std::exp(-0.5 * z * z));
        y.high = std::max(y.high, 1.08 * normal.y.back());
    }
    Legend legend;
    if (h.normal_sigma > 0)
        legend =
            legend_of({{"measured", series_colour(0)}, {h.normal_name, series_colour(1)}}, h.width);
    place(x, y, h.width, h.height, legend.height);
    const bool outside = bins.below + bins.above > 0;
    std::string out = svg_open(h.width, h.height + legend.height + (outside ? 18 : 0));
    for (std::size_t i = 0; i < bins.counts.size(); ++i) {
        const double left = x.at(bins.low + bins.width() * static_cast<double>(i));
        const double right = x.at(bins.low + bins.width() * static_cast<double>(i + 1));
        const double top = y.at(per_count * static_cast<double>(bins.counts[i]));
        out += "<rect x='" + svg_number(left) + "' y='" + svg_number(top) + "' width='" +
               svg_number(std::max(right - left - 0.5, 0.5)) + "' height='" +
               svg_number(y.from_px - top) + "' fill='" + series_colour(0) + "'/>\n";
    }
    out += svg_axes(x, y, axis_title(h.x), h.y_label);
    if (h.normal_sigma > 0) out += series_svg(normal, x, y, series_colour(1));
    out += legend.svg;
    if (outside)
        out += "<text x='" + svg_number(kLeft) + "' y='" +
               std::to_string(h.height + legend.height + 8) +
               "' fill='currentColor' fill-opacity='0.75'>outside the range: " +
               std::to_string(bins.below) + " below, " + std::to_string(bins.above) +
               " above, of " + std::to_string(bins.total) + "</text>\n";
    return out + "</svg>\n";
}

std::string colour_bar_svg(const ColourScale& scale, int width) {
    AxisSpan x{scale.low, scale.high > scale.low ? scale.high : scale.low + 1};
    x.from_px = 12;
    x.to_px = width - 12;
    std::string out = svg_open(width, 54);
    constexpr int kSteps = 64;
    for (int i = 0; i < kSteps; ++i) {
        const Eigen::Vector3f c = colour_of(scale, x.low + (x.high - x.low) * (i + 0.5) / kSteps);
        const double left = x.from_px + (x.to_px - x.from_px) * i / kSteps;
        out += "<rect x='" + svg_number(left) + "' y='2' width='" +
               svg_number((x.to_px - x.from_px) / kSteps + 0.4) +
               "' height='14' shape-rendering='crispEdges' fill='rgb(" +
               std::to_string(std::lround(255 * c[0])) + "," +
               std::to_string(std::lround(255 * c[1])) + "," +
               std::to_string(std::lround(255 * c[2])) + ")'/>\n";
    }
    for (const double tick : tick_values(x, 5))
        out += "<text x='" + svg_number(x.at(tick)) +
               "' y='30' text-anchor='middle' fill='currentColor'>" + tick_text(tick) + "</text>\n";
    out += "<text x='" + svg_number(0.5 * width) + "' y='48' text-anchor='middle' " +
           "fill='currentColor'>" + escape_markup(axis_title({scale.label, scale.unit})) +
           "</text>\n";
    return out + "</svg>\n";
}

}  // namespace stria
