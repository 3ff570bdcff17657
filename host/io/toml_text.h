#pragma once
#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>

#include "host/core/rigid3.h"
#include "host/io/toml_file.h"

/// What several TOML files of ours have in common: vectors, rigid motions, lines of text.
namespace stria {

/// "key = 1.0\n", the shortest number that reads back the same.
std::string toml_line(const std::string& key, double value);
/// "key = \"value\"\n"
std::string toml_line(const std::string& key, std::string_view value);
/// "key = [1.0, 2.0]\n"
std::string toml_line(const std::string& key, std::span<const double> values);
std::string toml_line(const std::string& key, const Eigen::Vector3d& value);
/// A matrix row by row, one row a line.
std::string toml_matrix(const std::string& key, const Eigen::MatrixXd& matrix);
/// The 16 numbers of a 4x4 matrix.
std::string toml_matrix(const std::string& key, const Rigid3& motion);

Eigen::Vector3d read_vector(TomlTable& table, const std::string& key);
/// A vector whose length must be 1 within 1e-6.
Eigen::Vector3d read_unit_vector(TomlTable& table, const std::string& key);
/// 16 numbers; the last row must be 0 0 0 1 and the rotation one within 1e-3. Matrices that are not
/// rotations within 1e-9 (printed with few digits) give the nearest rotation, others their bits.
Rigid3 read_rigid(TomlTable& table, const std::string& key);

/// The motion of 16 numbers, row by row, as read_rigid; else empty and `why` says what is wrong.
std::optional<Rigid3> rigid_from_numbers(std::span<const double> numbers, std::string& why);

}  // namespace stria
