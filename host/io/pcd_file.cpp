#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "host/core/errors.h"
#include "host/io/mesh_formats.h"
#include "host/io/number_text.h"
#include "host/io/ply_writer.h"
#include "host/io/text_lines.h"

namespace stria {
namespace {

struct PcdField {
    std::string name;
    std::size_t size = 4;
    char type = 'F';
    std::size_t count = 1;
    std::size_t offset = 0;  ///< in a point of a binary file
};

struct PcdHeader {
    std::vector<PcdField> fields;
    std::size_t points = 0;
    std::string data;             ///< ascii, binary, binary_compressed
    std::size_t point_bytes = 0;  ///< binary
    std::size_t values = 0;       ///< numbers a point
};

std::size_t positive(TextLines& lines, const char* what, std::int64_t most) {
    const std::int64_t value = lines.integer(what);
    if (value < 0 || value > most)
        lines.fail(std::string("expected ") + what + " of 0 to " + std::to_string(most) +
                   ", found " + std::to_string(value));
    return static_cast<std::size_t>(value);
}

void check_field(const PcdField& field, TextLines& lines) {
    const bool integer = field.type == 'I' || field.type == 'U';
    const bool known =
        integer ? field.size == 1 || field.size == 2 || field.size == 4 || field.size == 8
                : field.type == 'F' && (field.size == 4 || field.size == 8);
    if (!known)
        lines.fail("field " + shown(field.name) +
                   ": expected TYPE I or U of SIZE 1, 2, 4, 8 or F "
                   "of SIZE 4, 8, found " +
                   field.type + " of " + std::to_string(field.size));
}

constexpr std::int64_t kMostPoints = std::int64_t{1} << 32;

PcdHeader read_header(TextLines& lines) {
    PcdHeader header;
    std::size_t width = 0, height = 1;
    bool has_points = false;
    while (header.data.empty() && lines.next()) {
        const std::string_view key = lines.word();
        if (key.empty() || key[0] == '#' || key == "VERSION" || key == "VIEWPOINT") continue;
        if (key == "FIELDS" || key == "COLUMNS") {
            for (auto name = lines.word(); !name.empty(); name = lines.word())
                header.fields.push_back({std::string(name)});
        } else if (key == "SIZE") {
            for (PcdField& field : header.fields) field.size = positive(lines, "a SIZE", 8);
        } else if (key == "TYPE") {
            for (PcdField& field : header.fields) {
                const std::string_view type = lines.word();
                field.type = type.size() == 1 ? type[0] : '?';
            }
        } else if (key == "COUNT") {
            for (PcdField& field : header.fields) field.count = positive(lines, "a COUNT", 4096);
        } else if (key == "WIDTH") {
            width = positive(lines, "a WIDTH", kMostPoints);
        } else if (key == "HEIGHT") {
            height = positive(lines, "a HEIGHT", kMostPoints);
        } else if (key == "POINTS") {
            header.points = positive(lines, "POINTS", kMostPoints);
            has_points = true;
        } else if (key == "DATA") {
            header.data = std::string(lines.word());
        } else {
            lines.fail("expected a line of a PCD header, found '" + shown(lines.line()) + "'");
        }
    }
    if (header.data.empty()) lines.fail("expected 'DATA', found the end of the file");
    const bool organised = width > 0 && height > 0;
    if (!has_points)
        header.points = organised && width <= (std::size_t{1} << 32) / height ? width * height : 0;
    for (PcdField& field : header.fields) {
        check_field(field, lines);
        field.offset = header.point_bytes;
        header.point_bytes += field.size * field.count;
        header.values += field.count;
    }
    if (header.values == 0) lines.fail("expected 'FIELDS x y z' before DATA, found none");
    return header;
}

/// Little endian bytes as the field's type.
double decode(const char* from, const PcdField& field) {
    std::uint64_t raw = 0;
    for (std::size_t k = field.size; k-- > 0;) raw = raw << 8 | static_cast<std::uint8_t>(from[k]);
    if (field.type == 'F')
        return field.size == 8
                   ? std::bit_cast<double>(raw)
                   : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(raw)));
    if (field.type == 'U') return static_cast<double>(raw);
    const auto shift = static_cast<unsigned>(64 - 8 * field.size);
    return static_cast<double>(static_cast<std::int64_t>(raw << shift) >> shift);
}

/// One column a component, in the order of the file.
std::vector<NamedColumn> make_columns(const PcdHeader& header) {
    std::vector<NamedColumn> columns;
    for (const PcdField& field : header.fields)
        for (std::size_t k = 0; k < field.count; ++k)
            columns.push_back({field.count == 1 ? field.name : field.name + "_" + std::to_string(k),
                               std::vector<double>(header.points)});
    return columns;
}

std::vector<NamedColumn> read_ascii(const PcdHeader& header, TextLines& lines) {
    if (header.points > (lines.left() + 1) / (2 * header.values))
        lines.fail("claims " + std::to_string(header.points) + " points, more than the " +
                   std::to_string(lines.left()) + " bytes left can hold");
    std::vector<NamedColumn> columns = make_columns(header);
    for (std::size_t i = 0; i < header.points; ++i) {
        do {
            if (!lines.next())
                lines.fail("expected " + std::to_string(header.points) + " points, found " +
                           std::to_string(i));
        } while (lines.rest().empty());
        for (NamedColumn& column : columns) column.values[i] = lines.number("a field's value");
    }
    return columns;
}

/// @param by_field  all values of one field stand together, as in compressed files
std::vector<NamedColumn> read_binary(const PcdHeader& header, std::string_view data,
                                     bool by_field) {
    std::vector<NamedColumn> columns = make_columns(header);
    std::size_t column = 0;
    for (const PcdField& field : header.fields) {
        const std::size_t start = by_field ? field.offset * header.points : field.offset;
        const std::size_t stride = by_field ? field.size * field.count : header.point_bytes;
        for (std::size_t k = 0; k < field.count; ++k, ++column) {
            const char* from = data.data() + start + k * field.size;
            for (double& value : columns[column].values) {
                value = decode(from, field);
                from += stride;
            }
        }
    }
    return columns;
}

void check_size(const PcdHeader& header, std::size_t bytes, TextLines& lines) {
    if (header.points > bytes / header.point_bytes)
        lines.fail("expected " + std::to_string(header.points) + " points of " +
                   std::to_string(header.point_bytes) + " bytes, found " + std::to_string(bytes) +
                   " bytes");
}

std::vector<NamedColumn> read_compressed(const PcdHeader& header, std::string_view data,
                                         TextLines& lines) {
    if (data.size() < 8) lines.fail("expected two sizes and compressed data, found the end");
    const PcdField u32{"", 4, 'U'};
    const auto compressed = static_cast<std::size_t>(decode(data.data(), u32));
    const auto size = static_cast<std::size_t>(decode(data.data() + 4, u32));
    data.remove_prefix(8);
    if (compressed > data.size())
        lines.fail("claims " + std::to_string(compressed) + " compressed bytes, found " +
                   std::to_string(data.size()));
    // A run of LZF is at most 264 bytes long and takes 3.
    if (size > 88 * compressed + 264)
        lines.fail("claims " + std::to_string(size) + " bytes from " + std::to_string(compressed) +
                   " compressed ones, more than LZF can pack");
    check_size(header, size, lines);
    const std::string plain = lzf_decompress(data.substr(0, compressed), size);
    if (plain.size() != size) lines.fail("the compressed data is damaged");
    return read_binary(header, plain, true);
}

/// PCL packs 8-bit r g b into one 4-byte field "rgb" or "rgba".
void unpack_colour(const PcdHeader& header, std::vector<NamedColumn>& columns) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
        if (columns[c].name != "rgb" && columns[c].name != "rgba") continue;
        const auto field =
            std::find_if(header.fields.begin(), header.fields.end(),
                         [&](const PcdField& f) { return f.name == columns[c].name; });
        if (field == header.fields.end() || field->size != 4) return;
        const std::vector<double> packed = std::move(columns[c].values);
        NamedColumn parts[3] = {{"red", {}, 255.0}, {"green", {}, 255.0}, {"blue", {}, 255.0}};
        for (NamedColumn& part : parts) part.values.reserve(packed.size());
        for (const double value : packed) {
            std::uint32_t bits = 0;
            if (field->type == 'F')
                bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
            else if (value >= 0 && value < 4294967296.0)
                bits = static_cast<std::uint32_t>(value);
            for (unsigned k = 0; k < 3; ++k) parts[k].values.push_back(bits >> (16 - 8 * k) & 255);
        }
        columns.erase(columns.begin() + static_cast<std::ptrdiff_t>(c));
        for (NamedColumn& part : parts) columns.push_back(std::move(part));
        return;
    }
}

}  // namespace

PointCloud parse_pcd(std::string_view bytes, const std::string& name) {
    TextLines lines(bytes, name);
    const PcdHeader header = read_header(lines);
    const std::string_view data = bytes.substr(lines.offset());
    std::vector<NamedColumn> columns;
    if (header.data == "ascii") {
        columns = read_ascii(header, lines);
    } else if (header.data == "binary") {
        check_size(header, data.size(), lines);
        columns = read_binary(header, data, false);
    } else if (header.data == "binary_compressed") {
        columns = read_compressed(header, data, lines);
    } else {
        lines.fail("expected DATA ascii, binary or binary_compressed, found '" +
                   shown(header.data) + "'");
    }
    unpack_colour(header, columns);
    return cloud_from_columns(std::move(columns), name);
}

std::string format_pcd(const PointCloud& cloud) {
    std::string names = "x y z";
    std::size_t fields = 3;
    for (const VertexAttribute& attribute : cloud.attributes)
        for (const std::string& component : component_names(attribute)) {
            const bool normal = component == "nx" || component == "ny" || component == "nz";
            names += normal ? std::string(" normal_") + component[1] : " " + component;
            ++fields;
        }
    const auto repeated = [&](const char* word) {
        std::string text;
        for (std::size_t i = 0; i < fields; ++i) text += word;
        return text;
    };
    const std::string count = std::to_string(cloud.positions.size());
    std::string bytes = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS " + names +
                        "\nSIZE" + repeated(" 4") + "\nTYPE" + repeated(" F") + "\nCOUNT" +
                        repeated(" 1") + "\nWIDTH " + count +
                        "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n";
    bytes.reserve(bytes.size() + 4 * fields * cloud.positions.size());
    LittleEndianBytes out(bytes);
    for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
        for (int k = 0; k < 3; ++k) out.put_float(cloud.positions[i][k]);
        for (const VertexAttribute& attribute : cloud.attributes) {
            const auto n = static_cast<std::size_t>(attribute.components);
            for (std::size_t k = 0; k < n; ++k) out.put(attribute.values[i * n + k]);
        }
    }
    return bytes;
}

}  // namespace stria
