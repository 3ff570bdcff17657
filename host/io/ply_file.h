#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// PLY files of any content, ascii and both binary byte orders, as tables of numbers.
/// G. Turk, "The PLY Polygon File Format", 1994.
namespace stria {

enum class PlyType : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };
enum class PlyFormat : std::uint8_t { ascii, little_endian, big_endian };

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::f32;
    bool is_list = false;
    PlyType count_type = PlyType::u8;  ///< of a list
};

struct PlyElement {
    std::string name;
    std::size_t count = 0;
    std::vector<PlyProperty> properties;
};

struct PlyHeader {
    PlyFormat format = PlyFormat::ascii;
    std::vector<PlyElement> elements;
    std::vector<std::string> obj_info;  ///< what follows the word, one a line
    std::size_t body_offset = 0;        ///< bytes
    std::size_t body_line = 0;          ///< number of its first line

    const PlyElement* find(std::string_view element) const;
    /// What follows `key` in an obj_info line; empty if there is none.
    std::string info(std::string_view key) const;
};

/// Values of one property: one a row, or a list's values joined, row i being
/// values[begin[i]] .. values[begin[i + 1]].
struct PlyColumn {
    std::vector<double> values;
    std::vector<std::size_t> begin;  ///< lists only: rows + 1
};

struct PlyTable {
    PlyElement element;
    std::vector<PlyColumn> columns;  ///< as element.properties

    /// The column of that name; nullptr if there is none of that kind.
    const PlyColumn* scalars(std::string_view property) const;
    const PlyColumn* lists(std::string_view property) const;
    const PlyProperty* property(std::string_view name) const;
};

struct PlyFile {
    PlyHeader header;
    std::vector<PlyTable> tables;  ///< as header.elements

    const PlyTable* find(std::string_view element) const;
};

std::size_t size_of(PlyType type);

/// Reads the header alone. Throws FileError with the line.
PlyHeader parse_ply_header(std::string_view bytes, const std::string& name);

/// Reads the whole file. Counts are held against the bytes that are left before memory is taken:
/// memory is at most 16 times the file, 2 to 4 times for usual ones. Throws FileError with line
/// or byte, element and row.
PlyFile parse_ply(std::string_view bytes, const std::string& name);

}  // namespace stria
