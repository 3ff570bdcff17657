#include "host/render/svg_axes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace stria {
namespace {

std::string line(double x1, double y1, double x2, double y2, const char* opacity) {
    return "<line x1='" + svg_number(x1) + "' y1='" + svg_number(y1) + "' x2='" + svg_number(x2) +
           "' y2='" + svg_number(y2) + "' stroke='currentColor' stroke-opacity='" + opacity +
           "'/>\n";
}

std::string text_at(double x, double y, const char* anchor, const std::string& text) {
    return "<text x='" + svg_number(x) + "' y='" + svg_number(y) + "' text-anchor='" + anchor +
           "' fill='currentColor'>" + escape_markup(text) + "</text>\n";
}

}  // namespace

double AxisSpan::at(double value) const {
    const double share = logarithmic
                             ? (std::log(value) - std::log(low)) / (std::log(high) - std::log(low))
                             : (value - low) / (high - low);
    return from_px + share * (to_px - from_px);
}

std::vector<double> tick_values(const AxisSpan& span, int wanted) {
    std::vector<double> ticks;
    if (span.logarithmic) {
        const int first = static_cast<int>(std::ceil(std::log10(span.low) - 1e-9));
        const int last = static_cast<int>(std::floor(std::log10(span.high) + 1e-9));
        const int stride = std::max(1, (last - first) / std::max(wanted, 1));
        for (int e = first; e <= last; e += stride) ticks.push_back(std::pow(10.0, e));
        if (ticks.size() >= 2) return ticks;
        ticks.clear();
    }
    const double raw = (span.high - span.low) / wanted;
    const double power = std::pow(10.0, std::floor(std::log10(raw)));
    double step = 10 * power;
    for (const double candidate : {5.0, 2.0, 1.0})
        if (candidate * power >= raw * (1 - 1e-9)) step = candidate * power;
    if (span.whole) step = std::max(step, 1.0);
    for (double k = std::ceil(span.low / step - 1e-9); k * step <= span.high + 1e-9 * step; ++k)
        ticks.push_back(k == 0 ? 0.0 : k * step);
    return ticks;
}

std::string tick_text(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

std::string axis_title(const PlotAxis& axis) {
    return axis.unit.empty() ? axis.label : axis.label + " (" + axis.unit + ")";
}

std::string escape_markup(const std::string& text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            case '\'':
                out += "&#39;";
                break;
            default:
                out += c;
        }
    }
    return out;
}

std::string svg_axes(const AxisSpan& x, const AxisSpan& y, const std::string& x_title,
                     const std::string& y_title) {
    std::string out;
    for (const double tick : tick_values(x, 6)) {
        const double px = x.at(tick);
        out += line(px, y.from_px, px, y.to_px, "0.12");
        out += line(px, y.from_px, px, y.from_px + 4, "0.7");
        out += text_at(px, y.from_px + 17, "middle", tick_text(tick));
    }
    for (const double tick : tick_values(y, 5)) {
        const double py = y.at(tick);
        out += line(x.from_px, py, x.to_px, py, "0.12");
        out += line(x.from_px - 4, py, x.from_px, py, "0.7");
        out += text_at(x.from_px - 8, py + 4, "end", tick_text(tick));
    }
    out += line(x.from_px, y.from_px, x.to_px, y.from_px, "0.7");
    out += line(x.from_px, y.from_px, x.from_px, y.to_px, "0.7");
    out += text_at(0.5 * (x.from_px + x.to_px), y.from_px + 36, "middle", x_title);
    const double middle = 0.5 * (y.from_px + y.to_px);
    out += "<text x='14' y='" + svg_number(middle) + "' text-anchor='middle' fill='currentColor' " +
           "transform='rotate(-90 14 " + svg_number(middle) + ")'>" + escape_markup(y_title) +
           "</text>\n";
    return out;
}

std::string svg_open(int width, int height) {
    const std::string w = std::to_string(width), h = std::to_string(height);
    return "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 " + w + " " + h + "' width='" + w +
           "' height='" + h + "' font-size='12' font-family='system-ui, sans-serif'>\n";
}

std::string svg_number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2f", value);
    return text;
}

std::string series_colour(std::size_t i) {
    static constexpr std::array<const char*, 6> kColours = {"#3b82d6", "#e07b25", "#2c9f6b",
                                                            "#b455a8", "#8a8a8a", "#c9a30b"};
    return kColours[i % kColours.size()];
}

}  // namespace stria
