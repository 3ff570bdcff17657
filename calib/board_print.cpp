#include "calib/board_print.h"

#include <cstdio>
#include <string>
#include <vector>

#include "calib/board_shapes.h"
#include "host/core/errors.h"

namespace stria {
namespace {

constexpr double kMarginMm = 12, kFooterMm = 16;
constexpr double kPointsPerMm = 72 / 25.4;
constexpr double kLargestMm = 5000;

std::string number(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.5f", value);
    std::string out(text);
    while (out.back() == '0') out.pop_back();
    if (out.back() == '.') out.pop_back();
    return out == "-0" ? "0" : out;
}

/// A page in mm, y down: shapes moved so that the paper's corner is the origin, ruler added.
struct Page {
    double width = 0, height = 0;
    BoardShapes shapes;
    std::string text;
    double text_x = 0, text_y = 0;  ///< base line
};

Page lay_out(const Board& board) {
    Page page;
    page.shapes = board_shapes(board);
    const Eigen::Vector2d size = page.shapes.max_mm - page.shapes.min_mm;
    const double ruler = size.x() >= 100 ? 100 : size.x() >= 50 ? 50 : 10;
    page.width = size.x() + 2 * kMarginMm;
    page.height = size.y() + 2 * kMarginMm + kFooterMm;
    if (page.width > kLargestMm || page.height > kLargestMm)
        throw Error("board " + to_string(board) + " needs a page of " + number(page.width) + " x " +
                    number(page.height) + " mm; at most 5000 mm a side can be printed");
    const double dx = kMarginMm - page.shapes.min_mm.x();
    const double dy = kMarginMm - page.shapes.min_mm.y();
    for (BoardRect& rect : page.shapes.rects) {
        rect.x += dx;
        rect.y += dy;
    }
    for (BoardDisc& disc : page.shapes.discs) {
        disc.x += dx;
        disc.y += dy;
    }
    const double top = size.y() + 2 * kMarginMm;
    page.shapes.rects.push_back({kMarginMm, top + 6, ruler, 0.2});
    for (int mm = 0; mm <= static_cast<int>(ruler); mm += 10)
        page.shapes.rects.push_back({kMarginMm + mm - 0.1, top + (mm % 50 == 0 ? 3.0 : 4.5), 0.2,
                                     mm % 50 == 0 ? 3.2 : 1.7});
    page.text = to_string(board) + "   ruler " + number(ruler) +
                " mm: print at 100 %, measure it, glue flat";
    page.text_x = kMarginMm;
    page.text_y = top + 11;
    return page;
}

/// Disc in four Bezier arcs, to 3e-4 of its radius. PDF, points, y up.
std::string pdf_disc(double x, double y, double r) {
    const double k = 0.5522847498 * r;
    const auto p = [](double a, double b) { return number(a) + " " + number(b) + " "; };
    return p(x + r, y) + "m " + p(x + r, y + k) + p(x + k, y + r) + p(x, y + r) + "c " +
           p(x - k, y + r) + p(x - r, y + k) + p(x - r, y) + "c " + p(x - r, y - k) +
           p(x - k, y - r) + p(x, y - r) + "c " + p(x + k, y - r) + p(x + r, y - k) + p(x + r, y) +
           "c f\n";
}

std::string pdf_content(const Page& page) {
    const auto pt = [](double mm) { return mm * kPointsPerMm; };
    const auto up = [&](double mm) { return pt(page.height - mm); };
    std::string out = "0 g\n";
    for (const BoardRect& rect : page.shapes.rects)
        out += number(pt(rect.x)) + " " + number(up(rect.y + rect.height)) + " " +
               number(pt(rect.width)) + " " + number(pt(rect.height)) + " re f\n";
    for (const BoardDisc& disc : page.shapes.discs)
        out += pdf_disc(pt(disc.x), up(disc.y), pt(disc.radius));
    out += "BT /F1 8 Tf " + number(pt(page.text_x)) + " " + number(up(page.text_y)) + " Td (" +
           page.text + ") Tj ET\n";
    return out;
}

}  // namespace

std::string board_pdf(const Board& board) {
    const Page page = lay_out(board);
    const std::string content = pdf_content(page);
    const std::vector<std::string> objects = {
        "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
        "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 " + number(page.width * kPointsPerMm) + " " +
            number(page.height * kPointsPerMm) +
            "] /Contents 4 0 R /Resources << /Font << /F1 5 0 R >> >> >>",
        "<< /Length " + std::to_string(content.size()) + " >>\nstream\n" + content + "endstream",
        "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"};
    std::string out = "%PDF-1.4\n";
    std::vector<std::size_t> at;
    for (std::size_t i = 0; i < objects.size(); ++i) {
        at.push_back(out.size());
        out += std::to_string(i + 1) + " 0 obj\n" + objects[i] + "\nendobj\n";
    }
    const std::size_t table = out.size();
    out += "xref\n0 " + std::to_string(objects.size() + 1) + "\n0000000000 65535 f \n";
    for (std::size_t offset : at) {
        char entry[32];
        std::snprintf(entry, sizeof entry, "%010zu 00000 n \n", offset);
        out += entry;
    }
    return out + "trailer\n<< /Size " + std::to_string(objects.size() + 1) +
           " /Root 1 0 R >>\nstartxref\n" + std::to_string(table) + "\n%%EOF\n";
}

std::string board_svg(const Board& board) {
    const Page page = lay_out(board);
    const auto attribute = [](const char* name, double value) {
        return std::string(" ") + name + "=\"" + number(value) + "\"";
    };
    std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + number(page.width) +
                      "mm\" height=\"" + number(page.height) + "mm\" viewBox=\"0 0 " +
                      number(page.width) + " " + number(page.height) + "\">\n<rect" +
                      attribute("width", page.width) + attribute("height", page.height) +
                      " fill=\"white\"/>\n<g fill=\"black\" shape-rendering=\"crispEdges\">\n";
    for (const BoardRect& rect : page.shapes.rects)
        out += "<rect" + attribute("x", rect.x) + attribute("y", rect.y) +
               attribute("width", rect.width) + attribute("height", rect.height) + "/>\n";
    out += "</g>\n<g fill=\"black\">\n";
    for (const BoardDisc& disc : page.shapes.discs)
        out += "<circle" + attribute("cx", disc.x) + attribute("cy", disc.y) +
               attribute("r", disc.radius) + "/>\n";
    return out + "<text" + attribute("x", page.text_x) + attribute("y", page.text_y) +
           " font-family=\"Helvetica, Arial, sans-serif\" font-size=\"2.8\">" + page.text +
           "</text>\n</g>\n</svg>\n";
}

}  // namespace stria
