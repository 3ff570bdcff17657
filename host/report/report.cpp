#include "host/report/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "host/io/image_io.h"
#include "host/io/number_text.h"
#include "host/io/whole_file.h"
#include "host/render/plot.h"
#include "host/render/svg_axes.h"
#include "host/report/base64.h"
#include "host/report/mesh_viewer.h"
#include "host/report/page_parts.h"

namespace stria {
namespace {

/// Writes block after block; knows how many viewers there are.
class PageWriter {
  public:
    std::string html;
    int viewers = 0;

    void operator()(const ReportText& block) {
        std::size_t begin = 0;
        while (begin < block.text.size()) {
            std::size_t end = block.text.find("\n\n", begin);
            if (end == std::string::npos) end = block.text.size();
            html += "<p>" + escape_markup(block.text.substr(begin, end - begin)) + "</p>\n";
            begin = end + 2;
        }
    }

    void operator()(const ReportTable& table) {
        std::vector<bool> is_number(table.columns.size(), !table.rows.empty());
        for (const auto& row : table.rows) {
            if (row.size() != table.columns.size())
                throw std::invalid_argument("report: table '" + table.caption + "' has a row of " +
                                            std::to_string(row.size()) + " cells: expected " +
                                            std::to_string(table.columns.size()));
            for (std::size_t i = 0; i < row.size(); ++i)
                is_number[i] = is_number[i] && (row[i].empty() || row[i] == "-" ||
                                                parse_number(row[i]).has_value());
        }
        html += "<div class='scroll'><table>";
        if (!table.caption.empty())
            html += "<caption>" + escape_markup(table.caption) + "</caption>";
        html += "<thead><tr>";
        for (std::size_t i = 0; i < table.columns.size(); ++i)
            html += cell("th", table.columns[i], is_number[i]);
        html += "</tr></thead><tbody>\n";
        for (const auto& row : table.rows) {
            html += "<tr>";
            for (std::size_t i = 0; i < row.size(); ++i) html += cell("td", row[i], is_number[i]);
            html += "</tr>\n";
        }
        html += "</tbody></table></div>\n";
    }

    void operator()(const ReportPictures& block) {
        html += "<div class='row'>\n";
        for (const ReportPicture& picture : block.pictures) {
            const std::string caption = escape_markup(picture.caption);
            html += "<figure><img alt='" + caption + "' width='" +
                    std::to_string(picture.image.width) + "' height='" +
                    std::to_string(picture.image.height) + "' src='data:image/png;base64," +
                    to_base64(encode_png(picture.image)) + "'><figcaption>" + caption +
                    "</figcaption></figure>\n";
        }
        html += "</div>\n";
        if (block.scale) html += "<div>" + colour_bar_svg(*block.scale) + "</div>\n";
    }

    void operator()(const ReportDrawing& block) {
        html += "<figure>" + block.svg + "<figcaption>" + escape_markup(block.caption) +
                "</figcaption></figure>\n";
    }

    void operator()(const ReportMesh& block) {
        html += "<figure>" + mesh_viewer_html(block, "mesh" + std::to_string(++viewers));
        if (block.scale) html += "<div>" + colour_bar_svg(*block.scale) + "</div>\n";
        html += "<figcaption>" + escape_markup(block.caption) +
                " Drag to turn, with shift to move, wheel to zoom, double click to start again."
                "</figcaption></figure>\n";
    }

  private:
    static std::string cell(const char* tag, const std::string& text, bool number) {
        return std::string("<") + tag + (number ? " class='number'>" : ">") + escape_markup(text) +
               "</" + tag + ">";
    }
};

std::string summary_html(const std::vector<ReportFigure>& figures) {
    if (figures.empty()) return {};
    std::string out =
        "<table class='summary'><thead><tr><th>figure</th><th class='number'>value</th>"
        "<th>unit</th><th>limit</th><th></th></tr></thead><tbody>\n";
    for (const ReportFigure& f : figures) {
        out += "<tr><td>" + escape_markup(f.name) + "</td><td class='number'>" +
               escape_markup(f.value) + "</td><td>" + escape_markup(f.unit) + "</td><td>" +
               escape_markup(f.limit) + "</td>";
        if (f.kept)
            out += *f.kept ? "<td class='kept'>kept</td>" : "<td class='missed'>missed</td>";
        else
            out += "<td></td>";
        out += "</tr>\n";
    }
    return out + "</tbody></table>\n";
}

}  // namespace

std::string to_html(const Report& report) {
    PageWriter page;
    const std::string title = escape_markup(report.title);
    page.html =
        "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>\n"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>\n"
        "<title>" +
        title + "</title>\n<style>" + kPageStyle + "</style></head><body>\n<h1>" + title +
        "</h1>\n<p class='subtitle'>" + escape_markup(report.subtitle) + "</p>\n" +
        summary_html(report.summary);
    for (const ReportSection& section : report.sections) {
        page.html += "<section><h2>" + escape_markup(section.title) + "</h2>\n";
        for (const ReportBlock& block : section.blocks)
            std::visit([&](const auto& b) { page(b); }, block);
        page.html += "</section>\n";
    }
    if (page.viewers > 0) page.html += std::string("<script>") + kViewerScript + "</script>\n";
    return page.html + "</body></html>\n";
}

void write_report(const std::string& path, const Report& report) {
    write_whole_file(path, to_html(report));
}

std::string format_number(double value, int digits) {
    if (!std::isfinite(value)) return "-";
    char text[48];
    const double size = std::abs(value);
    if (size != 0 && (size < 1e-4 || size >= 1e7)) {
        std::snprintf(text, sizeof text, "%.*e", digits - 1, value);
    } else {
        const int exponent = size > 0 ? static_cast<int>(std::floor(std::log10(size))) : 0;
        std::snprintf(text, sizeof text, "%.*f", std::max(digits - 1 - exponent, 0), value);
    }
    return text;
}

}  // namespace stria
