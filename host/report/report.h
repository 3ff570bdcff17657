#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "host/core/image.h"
#include "host/core/tri_mesh.h"
#include "host/render/colour_map.h"

namespace stria {

/// Text in sentences. Every text of a report is plain and escaped; blank lines part paragraphs.
struct ReportText {
    std::string text;
};

/// A table; cells that are numbers are set right. The unit belongs into the column's title.
struct ReportTable {
    std::string caption;
    std::vector<std::string> columns;
    std::vector<std::vector<std::string>> rows;  ///< each as long as columns
};

/// One picture, inlined as PNG.
struct ReportPicture {
    std::string caption;
    ColourImage image;
};

/// Pictures beside each other, with the colour bar they share.
struct ReportPictures {
    std::vector<ReportPicture> pictures;
    std::optional<ColourScale> scale;
};

/// A drawing from host/render/plot.h.
struct ReportDrawing {
    std::string caption;
    std::string svg;
};

/// A mesh to turn and zoom. Pass a small one: a vertex and its two triangles take 48 bytes of page.
struct ReportMesh {
    std::string caption;
    TriMesh mesh;
    std::vector<Eigen::Vector3f> colours;  ///< one a vertex, or empty
    std::optional<ColourScale> scale;
    Eigen::Vector3d towards_eye = {0.45, -0.8, 0.4};
    Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
};

using ReportBlock =
    std::variant<ReportText, ReportTable, ReportPictures, ReportDrawing, ReportMesh>;

struct ReportSection {
    std::string title;
    std::vector<ReportBlock> blocks;
};

/// A line of the summary: a figure with its unit, what it must keep, and whether it does.
struct ReportFigure {
    std::string name;
    std::string value;
    std::string unit;
    std::string limit;         ///< "<= 0.05"; may be empty
    std::optional<bool> kept;  ///< empty: nothing is asked of it
};

struct Report {
    std::string title;
    std::string subtitle;  ///< what was measured, when, with which version
    std::vector<ReportFigure> summary;
    std::vector<ReportSection> sections;
};

/// The report as one page that needs no other file and no network. Throws std::invalid_argument if
/// a table's row or a mesh's colours have the wrong length.
std::string to_html(const Report& report);

/// to_html, written whole or not at all.
void write_report(const std::string& path, const Report& report);

/// `value` with `digits` significant digits, for tables.
std::string format_number(double value, int digits = 3);

}  // namespace stria
