#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace stria {

/// One table of a TOML document, read strictly: every key must be asked for, and finish() refuses
/// what was not, naming the line and the nearest key that was. Numbers must be finite. Errors are
/// FileError with the line. toml++ stays behind it.
class TomlTable {
  public:
    ~TomlTable();
    TomlTable(TomlTable&&) noexcept;
    TomlTable& operator=(TomlTable&&) noexcept;

    bool has(const std::string& key);
    /// Value of that key; integers are taken as numbers. The first form throws if it is missing.
    double number(const std::string& key);
    double number(const std::string& key, double otherwise);
    std::int64_t integer(const std::string& key);
    std::int64_t integer(const std::string& key, std::int64_t otherwise);
    bool boolean(const std::string& key, bool otherwise);
    std::string text(const std::string& key);
    std::string text(const std::string& key, const std::string& otherwise);
    /// Array of numbers; `count` > 0 demands that many.
    std::vector<double> numbers(const std::string& key, std::size_t count = 0);
    std::vector<std::string> texts(const std::string& key);
    /// Sub-table: must exist / may be missing.
    TomlTable table(const std::string& key);
    std::optional<TomlTable> find_table(const std::string& key);
    /// [[key]]: empty if missing.
    std::vector<TomlTable> tables(const std::string& key);
    /// Refuses unasked keys, here and in every table taken from here.
    void finish();
    /// A FileError at that key's line.
    [[noreturn]] void refuse(const std::string& key, const std::string& what) const;

  private:
    friend TomlTable parse_toml(const std::string&, const std::string&);
    struct Node;
    explicit TomlTable(std::shared_ptr<Node> node);
    std::shared_ptr<Node> node_;
};

/// @param name  stands for the path in errors
TomlTable parse_toml(const std::string& text, const std::string& name);
TomlTable read_toml(const std::string& path);

}  // namespace stria
