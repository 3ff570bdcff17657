#include "host/io/toml_file.h"

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>

#include "host/core/errors.h"
#include "host/io/nearest_word.h"
#include "host/io/whole_file.h"

namespace stria {

/// A table of the document, the keys that were asked for and the tables that were taken from it.
struct TomlTable::Node {
    std::shared_ptr<const toml::table> document;
    const toml::table* table = nullptr;
    std::string name;   ///< of the file
    std::string where;  ///< "[channel.camera]" or "the top of the file"
    std::vector<std::string> asked;
    std::vector<std::shared_ptr<Node>> children;

    const toml::node* find(const std::string& key) {
        if (std::find(asked.begin(), asked.end(), key) == asked.end()) asked.push_back(key);
        return table->get(key);
    }

    [[noreturn]] void fail(const toml::source_region& at, const std::string& what) const {
        const auto line = at.begin.line;
        throw FileError(name, line > 0 ? "line " + std::to_string(line) : "", what);
    }

    /// The value of a key that must be there; a key close to it in spelling is pointed out.
    const toml::node& demand(const std::string& key) {
        if (const toml::node* value = find(key)) return *value;
        const std::string missing = "missing key '" + key + "' in " + where;
        for (const auto& [other, value] : *table) {
            const std::string found(other.str());
            const std::size_t close = std::max<std::size_t>(key.size() > 3 ? 2 : 1, key.size() / 3);
            if (std::find(asked.begin(), asked.end(), found) == asked.end() &&
                edit_distance(found, key) <= close)
                fail(other.source(), missing + ": found '" + found + "' here");
        }
        fail(table->source(), missing);
    }

    [[noreturn]] void wrong_type(const std::string& key, const toml::node& found,
                                 const std::string& expected) const {
        std::string type;
        switch (found.type()) {
            case toml::node_type::table:
                type = "a table";
                break;
            case toml::node_type::array:
                type = "an array";
                break;
            case toml::node_type::string:
                type = "a text";
                break;
            case toml::node_type::integer:
                type = "an integer";
                break;
            case toml::node_type::floating_point:
                type = "a number";
                break;
            case toml::node_type::boolean:
                type = "a boolean";
                break;
            default:
                type = "a date or time";
                break;
        }
        fail(found.source(),
             "'" + key + "' in " + where + ": expected " + expected + ", found " + type);
    }

    double number_of(const std::string& key, const toml::node& value) const {
        double result = 0;
        if (const auto* number = value.as_floating_point())
            result = number->get();
        else if (const auto* integer = value.as_integer())
            result = static_cast<double>(integer->get());
        else
            wrong_type(key, value, "a number");
        if (!std::isfinite(result))
            fail(value.source(), "'" + key + "' in " + where +
                                     ": expected a finite number, found " +
                                     (std::isnan(result) ? "nan" : "inf"));
        return result;
    }

    const toml::array& array_of(const std::string& key, const toml::node& value,
                                const std::string& of_what) const {
        const toml::array* array = value.as_array();
        if (!array) wrong_type(key, value, "an array of " + of_what);
        return *array;
    }

    std::shared_ptr<Node> child(const toml::table& of, const std::string& place) {
        auto node = std::make_shared<Node>();
        node->document = document;
        node->table = &of;
        node->name = name;
        node->where = place;
        children.push_back(node);
        return node;
    }

    /// "[a.b]" for the key b of this table [a].
    std::string place_of(const std::string& key) const {
        const bool nested = !where.empty() && where.front() == '[';
        if (!nested) return "[" + key + "]";
        const std::size_t first = where.find_first_not_of('[');
        return "[" + where.substr(first, where.find(']') - first) + "." + key + "]";
    }

    void finish() const {
        for (const auto& [key, value] : *table) {
            const std::string found(key.str());
            if (std::find(asked.begin(), asked.end(), found) != asked.end()) continue;
            std::string message = "unknown key '" + found + "' in " + where;
            const std::string nearest = nearest_word(found, asked);
            if (!nearest.empty()) message += ": the nearest known key is '" + nearest + "'";
            fail(key.source(), message);
        }
        for (const auto& node : children) node->finish();
    }
};

TomlTable::TomlTable(std::shared_ptr<Node> node) : node_(std::move(node)) {}
TomlTable::~TomlTable() = default;
TomlTable::TomlTable(TomlTable&&) noexcept = default;
TomlTable& TomlTable::operator=(TomlTable&&) noexcept = default;

bool TomlTable::has(const std::string& key) { return node_->find(key) != nullptr; }

double TomlTable::number(const std::string& key) {
    return node_->number_of(key, node_->demand(key));
}
double TomlTable::number(const std::string& key, double otherwise) {
    const toml::node* value = node_->find(key);
    return value ? node_->number_of(key, *value) : otherwise;
}

std::int64_t TomlTable::integer(const std::string& key) {
    const toml::node& value = node_->demand(key);
    if (!value.is_integer()) node_->wrong_type(key, value, "an integer");
    return value.as_integer()->get();
}
std::int64_t TomlTable::integer(const std::string& key, std::int64_t otherwise) {
    return has(key) ? integer(key) : otherwise;
}

bool TomlTable::boolean(const std::string& key, bool otherwise) {
    const toml::node* value = node_->find(key);
    if (!value) return otherwise;
    if (!value->is_boolean()) node_->wrong_type(key, *value, "true or false");
    return value->as_boolean()->get();
}

std::string TomlTable::text(const std::string& key) {
    const toml::node& value = node_->demand(key);
    if (!value.is_string()) node_->wrong_type(key, value, "a text in quotes");
    return value.as_string()->get();
}
std::string TomlTable::text(const std::string& key, const std::string& otherwise) {
    return has(key) ? text(key) : otherwise;
}

std::vector<double> TomlTable::numbers(const std::string& key, std::size_t count) {
    const toml::node& value = node_->demand(key);
    const toml::array& array = node_->array_of(key, value, "numbers");
    if (count > 0 && array.size() != count)
        refuse(key, "expected " + std::to_string(count) + " numbers, found " +
                        std::to_string(array.size()));
    std::vector<double> result;
    result.reserve(array.size());
    for (const toml::node& element : array) result.push_back(node_->number_of(key, element));
    return result;
}

std::vector<std::string> TomlTable::texts(const std::string& key) {
    const toml::node& value = node_->demand(key);
    std::vector<std::string> result;
    for (const toml::node& element : node_->array_of(key, value, "texts")) {
        if (!element.is_string()) node_->wrong_type(key, element, "texts in quotes");
        result.push_back(element.as_string()->get());
    }
    return result;
}

TomlTable TomlTable::table(const std::string& key) {
    const toml::node& value = node_->demand(key);
    if (!value.is_table()) node_->wrong_type(key, value, "a table " + node_->place_of(key));
    return TomlTable(node_->child(*value.as_table(), node_->place_of(key)));
}

std::optional<TomlTable> TomlTable::find_table(const std::string& key) {
    if (!has(key)) return std::nullopt;
    return table(key);
}

std::vector<TomlTable> TomlTable::tables(const std::string& key) {
    std::vector<TomlTable> result;
    const toml::node* value = node_->find(key);
    if (!value) return result;
    const std::string place = "[" + node_->place_of(key) + "]";
    for (const toml::node& element : node_->array_of(key, *value, "tables " + place)) {
        if (!element.is_table()) node_->wrong_type(key, element, "tables " + place);
        result.push_back(TomlTable(node_->child(*element.as_table(), place)));
    }
    return result;
}

void TomlTable::finish() { node_->finish(); }

void TomlTable::refuse(const std::string& key, const std::string& what) const {
    const toml::node* value = node_->table->get(key);
    node_->fail(value ? value->source() : node_->table->source(),
                "'" + key + "' in " + node_->where + ": " + what);
}

TomlTable parse_toml(const std::string& text, const std::string& name) {
    try {
        auto node = std::make_shared<TomlTable::Node>();
        node->document = std::make_shared<const toml::table>(toml::parse(text, name));
        node->table = node->document.get();
        node->name = name;
        node->where = "the top of the file";
        return TomlTable(std::move(node));
    } catch (const toml::parse_error& error) {
        throw FileError(name, "line " + std::to_string(error.source().begin.line),
                        std::string(error.description()));
    }
}

TomlTable read_toml(const std::string& path) {
    constexpr std::size_t kLargest = std::size_t{64} << 20;
    return parse_toml(read_whole_file(path, kLargest), path);
}

}  // namespace stria
