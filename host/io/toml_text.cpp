#include "host/io/toml_text.h"

#include <cmath>

#include "host/io/number_text.h"

namespace stria {
namespace {

std::string joined(std::span<const double> values) {
    std::string text;
    for (std::size_t i = 0; i < values.size(); ++i)
        text += (i ? ", " : "") + toml_number(values[i]);
    return text;
}

}  // namespace

std::string toml_line(const std::string& key, double value) {
    return key + " = " + toml_number(value) + "\n";
}

std::string toml_line(const std::string& key, std::string_view value) {
    return key + " = " + toml_text(value) + "\n";
}

std::string toml_line(const std::string& key, std::span<const double> values) {
    return key + " = [" + joined(values) + "]\n";
}

std::string toml_line(const std::string& key, const Eigen::Vector3d& value) {
    return toml_line(key, std::span<const double>(value.data(), 3));
}

std::string toml_matrix(const std::string& key, const Eigen::MatrixXd& matrix) {
    std::string text = key + " = [\n";
    for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
        const Eigen::VectorXd values = matrix.row(row);
        text += "    " + joined({values.data(), static_cast<std::size_t>(values.size())}) + ",\n";
    }
    return text + "]\n";
}

std::string toml_matrix(const std::string& key, const Rigid3& motion) {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topLeftCorner<3, 3>() = motion.rotation;
    matrix.topRightCorner<3, 1>() = motion.translation;
    return toml_matrix(key, Eigen::MatrixXd(matrix));
}

Eigen::Vector3d read_vector(TomlTable& table, const std::string& key) {
    const std::vector<double> values = table.numbers(key, 3);
    return {values[0], values[1], values[2]};
}

Eigen::Vector3d read_unit_vector(TomlTable& table, const std::string& key) {
    const Eigen::Vector3d value = read_vector(table, key);
    if (!(std::abs(value.norm() - 1) < 1e-6))
        table.refuse(key,
                     "expected a vector of length 1, found length " + std::to_string(value.norm()));
    return value;
}

std::optional<Rigid3> rigid_from_numbers(std::span<const double> n, std::string& why) {
    if (n.size() != 16) {
        why = "expected the 16 numbers of a 4x4 matrix, found " + std::to_string(n.size());
        return std::nullopt;
    }
    if (n[12] != 0 || n[13] != 0 || n[14] != 0 || n[15] != 1) {
        why = "expected the last row of a 4x4 matrix to be 0 0 0 1";
        return std::nullopt;
    }
    Rigid3 motion;
    motion.rotation << n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10];
    motion.translation << n[3], n[7], n[11];
    if (!is_rigid(motion, 1e-3)) {
        why = "expected a rotation and a translation; the 3x3 part is no rotation (within 0.001)";
        return std::nullopt;
    }
    if (!is_rigid(motion, 1e-9)) motion.rotation = nearest_rotation(motion.rotation);
    return motion;
}

Rigid3 read_rigid(TomlTable& table, const std::string& key) {
    std::string why;
    const auto motion = rigid_from_numbers(table.numbers(key), why);
    if (!motion) table.refuse(key, why);
    return *motion;
}

}  // namespace stria
