#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "host/io/number_text.h"
#include "host/io/ply_file.h"
#include "host/io/text_lines.h"

namespace stria {
namespace {

std::string row_name(const PlyElement& element, std::size_t row) {
    return "element " + shown(element.name) + ", row " + std::to_string(row) + " of " +
           std::to_string(element.count);
}

/// Numbers of a binary body.
class BinarySource {
  public:
    BinarySource(std::string_view bytes, std::size_t at, bool swap, std::string name)
        : bytes_(bytes), at_(at), swap_(swap), name_(std::move(name)) {}

    /// The fewest bytes that `type` takes.
    static std::size_t least(PlyType type) { return size_of(type); }
    std::size_t left() const { return bytes_.size() - at_; }

    double number(PlyType type, const PlyElement& element, std::size_t row) {
        if (left() < size_of(type)) fail("the file ends too early", element, row);
        const double value = decode(bytes_.data() + at_, type);
        at_ += size_of(type);
        return value;
    }

    /// All rows of an element without lists, column by column.
    void read_columns(const PlyElement& element, std::vector<PlyColumn>& columns) {
        std::size_t stride = 0;
        for (const PlyProperty& property : element.properties) stride += size_of(property.type);
        std::size_t offset = at_;
        for (std::size_t c = 0; c < columns.size(); ++c) {
            const PlyType type = element.properties[c].type;
            columns[c].values.resize(element.count);
            const char* from = bytes_.data() + offset;
            read_column(from, stride, type, columns[c].values);
            offset += size_of(type);
        }
        at_ += stride * element.count;
    }

    [[noreturn]] void fail(const std::string& what, const PlyElement& element, std::size_t row) {
        throw FileError(name_, "byte " + std::to_string(at_), row_name(element, row) + ": " + what);
    }

  private:
    template <typename T>
    T load(const char* from) const {
        char raw[sizeof(T)];
        std::memcpy(raw, from, sizeof(T));
        if (swap_) std::reverse(raw, raw + sizeof(T));
        T value;
        std::memcpy(&value, raw, sizeof(T));
        return value;
    }

    template <typename T>
    void read_as(const char* from, std::size_t stride, std::vector<double>& values) const {
        for (double& value : values) {
            value = static_cast<double>(load<T>(from));
            from += stride;
        }
    }

    void read_column(const char* from, std::size_t stride, PlyType type,
                     std::vector<double>& values) const {
        switch (type) {
            case PlyType::i8:
                return read_as<std::int8_t>(from, stride, values);
            case PlyType::u8:
                return read_as<std::uint8_t>(from, stride, values);
            case PlyType::i16:
                return read_as<std::int16_t>(from, stride, values);
            case PlyType::u16:
                return read_as<std::uint16_t>(from, stride, values);
            case PlyType::i32:
                return read_as<std::int32_t>(from, stride, values);
            case PlyType::u32:
                return read_as<std::uint32_t>(from, stride, values);
            case PlyType::f32:
                return read_as<float>(from, stride, values);
            case PlyType::f64:
                return read_as<double>(from, stride, values);
        }
    }

    double decode(const char* from, PlyType type) const {
        switch (type) {
            case PlyType::i8:
                return load<std::int8_t>(from);
            case PlyType::u8:
                return load<std::uint8_t>(from);
            case PlyType::i16:
                return load<std::int16_t>(from);
            case PlyType::u16:
                return load<std::uint16_t>(from);
            case PlyType::i32:
                return load<std::int32_t>(from);
            case PlyType::u32:
                return load<std::uint32_t>(from);
            case PlyType::f32:
                return static_cast<double>(load<float>(from));
            case PlyType::f64:
                break;
        }
        return load<double>(from);
    }

    std::string_view bytes_;
    std::size_t at_;
    bool swap_;
    std::string name_;
};

bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// Numbers of an ascii body: a stream of words, wherever lines end.
class AsciiSource {
  public:
    AsciiSource(std::string_view bytes, std::size_t at, std::size_t line, std::string name)
        : bytes_(bytes), body_(at), line_(line), at_(at), name_(std::move(name)) {}

    static std::size_t least(PlyType) { return 2; }               // a digit and what parts it
    std::size_t left() const { return bytes_.size() - at_ + 1; }  // nothing parts the last one

    double number(PlyType, const PlyElement& element, std::size_t row) {
        while (at_ < bytes_.size() && is_space(bytes_[at_])) ++at_;
        const std::size_t begin = at_;
        double value = 0;
        const char* const end = bytes_.data() + bytes_.size();
        const auto result = std::from_chars(bytes_.data() + at_, end, value);
        if (result.ec == std::errc{} && (result.ptr == end || is_space(*result.ptr))) {
            at_ = static_cast<std::size_t>(result.ptr - bytes_.data());
            return value;
        }
        while (at_ < bytes_.size() && !is_space(bytes_[at_])) ++at_;
        const std::string_view word = bytes_.substr(begin, at_ - begin);
        const auto unusual = parse_number(word);  // with a plus, or below the least double
        if (!unusual) {
            at_ = begin;
            fail(word.empty() ? "the file ends too early"
                              : "expected a number, found '" + shown(word) + "'",
                 element, row);
        }
        return *unusual;
    }

    void read_columns(const PlyElement& element, std::vector<PlyColumn>& columns) {
        for (PlyColumn& column : columns) column.values.resize(element.count);
        for (std::size_t row = 0; row < element.count; ++row)
            for (PlyColumn& column : columns)
                column.values[row] = number(PlyType::f64, element, row);
    }

    [[noreturn]] void fail(const std::string& what, const PlyElement& element, std::size_t row) {
        const std::string_view before = bytes_.substr(body_, at_ - body_);
        const auto lines = std::count(before.begin(), before.end(), '\n');
        throw FileError(name_, "line " + std::to_string(line_ + static_cast<std::size_t>(lines)),
                        row_name(element, row) + ": " + what);
    }

  private:
    std::string_view bytes_;
    std::size_t body_, line_, at_;
    std::string name_;
};

template <typename Source>
void read_list(Source& source, const PlyElement& element, const PlyProperty& property,
               std::size_t row, PlyColumn& column) {
    const double count = source.number(property.count_type, element, row);
    if (!(count >= 0 && count <= 4294967295.0 && count == std::floor(count)))
        source.fail("expected the length of list " + shown(property.name) + ", found " +
                        std::to_string(count),
                    element, row);
    const auto n = static_cast<std::size_t>(count);
    if (n > source.left() / Source::least(property.type))
        source.fail("list " + shown(property.name) + " claims " + std::to_string(n) +
                        " values, more than the file holds",
                    element, row);
    for (std::size_t i = 0; i < n; ++i)
        column.values.push_back(source.number(property.type, element, row));
    column.begin.push_back(column.values.size());
}

template <typename Source>
PlyTable read_table(Source& source, const PlyElement& element) {
    PlyTable table{element, std::vector<PlyColumn>(element.properties.size())};
    if (element.properties.empty()) return table;
    std::size_t least = 0;
    bool has_lists = false;
    for (const PlyProperty& property : element.properties) {
        least += Source::least(property.is_list ? property.count_type : property.type);
        has_lists |= property.is_list;
    }
    if (element.count > source.left() / least)
        source.fail("the header claims more rows than the file holds", element,
                    source.left() / least);
    if (!has_lists) {
        source.read_columns(element, table.columns);
        return table;
    }
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
        if (element.properties[c].is_list) {
            table.columns[c].begin.reserve(element.count + 1);
            table.columns[c].begin.push_back(0);
            const std::size_t most = source.left() / Source::least(element.properties[c].type);
            table.columns[c].values.reserve(std::min(most, 3 * element.count));
        } else {
            table.columns[c].values.reserve(element.count);
        }
    }
    for (std::size_t row = 0; row < element.count; ++row)
        for (std::size_t c = 0; c < table.columns.size(); ++c) {
            const PlyProperty& property = element.properties[c];
            if (property.is_list)
                read_list(source, element, property, row, table.columns[c]);
            else
                table.columns[c].values.push_back(source.number(property.type, element, row));
        }
    return table;
}

template <typename Source>
void read_tables(Source source, PlyFile& file) {
    for (const PlyElement& element : file.header.elements)
        file.tables.push_back(read_table(source, element));
}

const PlyColumn* find_column(const PlyTable& table, std::string_view name, bool list) {
    for (std::size_t c = 0; c < table.columns.size(); ++c)
        if (table.element.properties[c].name == name && table.element.properties[c].is_list == list)
            return &table.columns[c];
    return nullptr;
}

}  // namespace

const PlyColumn* PlyTable::scalars(std::string_view property) const {
    return find_column(*this, property, false);
}
const PlyColumn* PlyTable::lists(std::string_view property) const {
    return find_column(*this, property, true);
}
const PlyProperty* PlyTable::property(std::string_view name) const {
    for (const PlyProperty& property : element.properties)
        if (property.name == name) return &property;
    return nullptr;
}

const PlyTable* PlyFile::find(std::string_view element) const {
    for (const PlyTable& table : tables)
        if (table.element.name == element) return &table;
    return nullptr;
}

PlyFile parse_ply(std::string_view bytes, const std::string& name) {
    PlyFile file;
    file.header = parse_ply_header(bytes, name);
    const PlyHeader& header = file.header;
    if (header.format == PlyFormat::ascii) {
        read_tables(AsciiSource(bytes, header.body_offset, header.body_line, name), file);
    } else {
        const bool swap = (header.format == PlyFormat::big_endian) ==
                          (std::endian::native == std::endian::little);
        read_tables(BinarySource(bytes, header.body_offset, swap, name), file);
    }
    return file;
}

}  // namespace stria
