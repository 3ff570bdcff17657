#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace stria::structure {

/// One row of include_table.txt.
struct IncludeRow {
    std::vector<std::string> folders;  ///< may be included directly; "X/*" and "*" as patterns
    std::vector<std::string> groups;   ///< third-party groups open to its .cpp files; "*": all
};

/// Rows by folder.
using IncludeTable = std::map<std::string, IncludeRow>;

/// Throws std::runtime_error naming the line when a row has not two colons or names a folder twice.
IncludeTable read_include_table(const std::filesystem::path& file);

/// The longest folder of the table that is `path` or holds it; empty when there is none.
std::string folder_of(const IncludeTable& table, const std::string& path);

/// Whether files of folder `from` may include files of folder `to` (both rows of the table).
bool may_include(const IncludeTable& table, const std::string& from, const std::string& to);

/// Third-party group of an include ("eigen", "posix"); "std" for the standard library; empty when
/// nobody knows the header.
std::string group_of(const std::string& header);

/// Whether a third-party group may be used in this row.
bool may_use(const IncludeRow& row, const std::string& group);

}  // namespace stria::structure
