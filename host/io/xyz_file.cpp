#include <algorithm>
#include <cmath>

#include "host/core/errors.h"
#include "host/io/mesh_formats.h"
#include "host/io/number_text.h"
#include "host/io/text_lines.h"

namespace stria {
namespace {

/// Columns without a header: x y z, then a normal where there are six and they look like one.
std::vector<std::string> names_of(std::size_t columns) {
    std::vector<std::string> names = {"x", "y", "z"};
    if (columns == 6) names.insert(names.end(), {"nx", "ny", "nz"});
    if (columns == 4) names.emplace_back("intensity");
    for (std::size_t c = names.size(); c < columns; ++c)
        names.push_back("column" + std::to_string(c + 1));
    return names;
}

/// Six columns are positions and normals only where the last three are unit vectors or zero.
bool are_normals(const std::vector<NamedColumn>& columns) {
    for (std::size_t i = 0; i < columns[3].values.size(); ++i) {
        const double length =
            std::hypot(columns[3].values[i], columns[4].values[i], columns[5].values[i]);
        if (!(length == 0 || std::abs(length - 1) < 0.02)) return false;
    }
    return true;
}

bool is_comment(std::string_view word) {
    return word.empty() || word[0] == '#' || word.starts_with("//");
}

std::string lower(std::string_view word) {
    std::string text(word);
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

/// Names of a header line; empty if the line begins with a number.
std::vector<std::string> header_names(TextLines lines) {
    std::vector<std::string> names;
    for (auto word = lines.word(); !word.empty(); word = lines.word()) {
        if (names.empty() && parse_number(word)) return {};
        if (word.size() > 1 && word.front() == '"' && word.back() == '"')
            word = word.substr(1, word.size() - 2);
        names.push_back(lower(word));
    }
    return names;
}

}  // namespace

PointCloud cloud_from_columns(std::vector<NamedColumn> columns, const std::string& name) {
    PointCloud cloud;
    const char* const kAxes[3] = {"x", "y", "z"};
    for (int k = 0; k < 3; ++k) {
        const auto found = std::find_if(columns.begin(), columns.end(),
                                        [&](const NamedColumn& c) { return c.name == kAxes[k]; });
        if (found == columns.end())
            throw FileError(name, "header",
                            std::string("expected a column '") + kAxes[k] + "', found none");
        cloud.positions.resize(found->values.size());
        for (std::size_t i = 0; i < found->values.size(); ++i)
            cloud.positions[i][k] = found->values[i];
        columns.erase(found);
    }
    cloud.attributes = attributes_from(std::move(columns));
    drop_points_not_finite(cloud);
    return cloud;
}

PointCloud parse_xyz(std::string_view bytes, const std::string& name) {
    TextLines lines(plain_text(bytes, name), name, " \t\v\f,;");
    std::vector<NamedColumn> columns;
    std::vector<std::string> names;
    bool has_header = false;
    while (lines.next()) {
        TextLines peek = lines;
        if (is_comment(peek.word())) continue;
        if (columns.empty()) {
            names = header_names(lines);
            has_header = !names.empty();
            if (!has_header) {
                std::size_t count = 0;
                for (TextLines words = lines; !words.word().empty();) ++count;
                if (count < 3) lines.fail("expected at least 3 numbers a line");
                names = names_of(count);
            }
            for (const std::string& column : names) columns.push_back({column, {}});
            if (has_header) continue;
        }
        for (NamedColumn& column : columns) column.values.push_back(lines.number("a number"));
        if (const std::string_view more = lines.word(); !is_comment(more))
            lines.fail("expected " + std::to_string(columns.size()) + " numbers, found more");
    }
    if (columns.empty()) return {};
    if (!has_header && columns.size() == 6 && !are_normals(columns))
        for (std::size_t c = 3; c < 6; ++c) columns[c].name = "column" + std::to_string(c + 1);
    return cloud_from_columns(std::move(columns), name);
}

std::string format_xyz(const PointCloud& cloud, char separator) {
    std::string text;
    if (separator == ',') {
        text = "x,y,z";
        for (const VertexAttribute& attribute : cloud.attributes)
            for (const std::string& component : component_names(attribute)) text += "," + component;
        text += '\n';
    }
    for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
            if (k > 0) text += separator;
            append_number(text, cloud.positions[i][k]);
        }
        for (const VertexAttribute& attribute : cloud.attributes) {
            // XYZ has no header, so it keeps what readers expect there: normals
            if (separator != ',' && attribute.name != "normal") continue;
            const auto n = static_cast<std::size_t>(attribute.components);
            for (std::size_t k = 0; k < n; ++k) {
                text += separator;
                append_number(text, attribute.values[i * n + k]);
            }
        }
        text += '\n';
    }
    return text;
}

}  // namespace stria
