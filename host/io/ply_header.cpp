#include <algorithm>
#include <array>

#include "host/io/ply_file.h"
#include "host/io/text_lines.h"

namespace stria {
namespace {

struct TypeName {
    const char* name;
    PlyType type;
};
constexpr std::array<TypeName, 16> kTypes = {{{"char", PlyType::i8},
                                              {"int8", PlyType::i8},
                                              {"uchar", PlyType::u8},
                                              {"uint8", PlyType::u8},
                                              {"short", PlyType::i16},
                                              {"int16", PlyType::i16},
                                              {"ushort", PlyType::u16},
                                              {"uint16", PlyType::u16},
                                              {"int", PlyType::i32},
                                              {"int32", PlyType::i32},
                                              {"uint", PlyType::u32},
                                              {"uint32", PlyType::u32},
                                              {"float", PlyType::f32},
                                              {"float32", PlyType::f32},
                                              {"double", PlyType::f64},
                                              {"float64", PlyType::f64}}};

PlyType read_type(TextLines& lines) {
    const std::string_view word = lines.word();
    for (const TypeName& type : kTypes)
        if (word == type.name) return type.type;
    lines.fail("expected a type (char, uchar, short, ushort, int, uint, float, double), found '" +
               shown(word) + "'");
}

PlyFormat read_format(TextLines& lines) {
    const std::string_view word = lines.word();
    if (word == "ascii") return PlyFormat::ascii;
    if (word == "binary_little_endian") return PlyFormat::little_endian;
    if (word == "binary_big_endian") return PlyFormat::big_endian;
    lines.fail("expected format ascii, binary_little_endian or binary_big_endian, found '" +
               shown(word) + "'");
}

PlyElement read_element(TextLines& lines, const PlyHeader& header) {
    PlyElement element;
    element.name = std::string(lines.word());
    if (element.name.empty()) lines.fail("expected 'element NAME COUNT'");
    if (header.find(element.name)) lines.fail("element " + shown(element.name) + " stands twice");
    const std::int64_t count = lines.integer("the element's count");
    if (count < 0) lines.fail("expected a count of at least 0, found " + std::to_string(count));
    element.count = static_cast<std::size_t>(count);
    return element;
}

PlyProperty read_property(TextLines& lines) {
    PlyProperty property;
    TextLines peek = lines;
    if (peek.word() == "list") {
        lines.word();
        property.is_list = true;
        property.count_type = read_type(lines);
        if (property.count_type == PlyType::f32 || property.count_type == PlyType::f64)
            lines.fail("expected an integer type for a list's count");
    }
    property.type = read_type(lines);
    property.name = std::string(lines.word());
    if (property.name.empty()) lines.fail("expected the property's name");
    return property;
}

}  // namespace

std::size_t size_of(PlyType type) {
    switch (type) {
        case PlyType::i8:
        case PlyType::u8:
            return 1;
        case PlyType::i16:
        case PlyType::u16:
            return 2;
        case PlyType::i32:
        case PlyType::u32:
        case PlyType::f32:
            return 4;
        case PlyType::f64:
            break;
    }
    return 8;
}

const PlyElement* PlyHeader::find(std::string_view element) const {
    const auto found = std::find_if(elements.begin(), elements.end(),
                                    [&](const PlyElement& e) { return e.name == element; });
    return found == elements.end() ? nullptr : &*found;
}

std::string PlyHeader::info(std::string_view key) const {
    for (const std::string& line : obj_info)
        if (line.size() > key.size() && line.compare(0, key.size(), key) == 0 &&
            line[key.size()] == ' ')
            return line.substr(key.size() + 1);
    return "";
}

PlyHeader parse_ply_header(std::string_view bytes, const std::string& name) {
    TextLines lines(bytes, name);
    if (!lines.next() || lines.word() != "ply")
        throw FileError(name, "line 1",
                        bytes.empty() ? "expected 'ply', found an empty file"
                                      : "expected 'ply', found '" + shown(lines.line()) + "'");
    // A lone CR ends the lines of old Macintosh files; then no LF belongs to the header.
    const bool lone_cr = bytes.size() > 4 && bytes[3] == '\r' && bytes[4] != '\n';
    PlyHeader header;
    bool has_format = false;
    while (lines.next()) {
        const std::string_view keyword = lines.word();
        if (keyword == "format") {
            header.format = read_format(lines);
            has_format = true;
        } else if (keyword == "element") {
            header.elements.push_back(read_element(lines, header));
        } else if (keyword == "property") {
            if (header.elements.empty()) lines.fail("a property stands before any element");
            header.elements.back().properties.push_back(read_property(lines));
        } else if (keyword == "obj_info") {
            header.obj_info.emplace_back(lines.rest());
        } else if (keyword == "end_header") {
            if (!has_format) lines.fail("the header ends without a format");
            const std::size_t word_end =
                static_cast<std::size_t>(lines.line().data() - bytes.data()) + lines.line().size();
            header.body_offset = lone_cr ? std::min(word_end + 1, bytes.size()) : lines.offset();
            header.body_line = lines.line_number() + 1;
            return header;
        } else if (keyword != "comment" && !keyword.empty()) {
            lines.fail("expected a line of a PLY header, found '" + shown(lines.line()) + "'");
        }
    }
    throw FileError(name, "line " + std::to_string(lines.line_number()),
                    "expected 'end_header', found the end of the file");
}

}  // namespace stria
