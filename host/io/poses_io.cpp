#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "host/core/errors.h"
#include "host/io/model_io.h"
#include "host/io/number_text.h"
#include "host/io/text_lines.h"
#include "host/io/toml_text.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

namespace fs = std::filesystem;

std::vector<ScanPose> parse_poses_toml(const std::string& text, const std::string& name) {
    TomlTable top = parse_toml(text, name);
    std::vector<ScanPose> poses;
    for (TomlTable& table : top.tables("scan")) {
        ScanPose pose;
        pose.file = table.text("file");
        pose.world_from_scan = read_rigid(table, "world_from_scan");
        if (table.has("covariance")) {
            const std::vector<double> values = table.numbers("covariance", 36);
            pose.covariance =
                Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(values.data());
        }
        pose.fixed = table.boolean("fixed", false);
        poses.push_back(std::move(pose));
    }
    top.finish();
    if (poses.empty()) throw FileError(name, "", "expected at least one [[scan]], found none");
    return poses;
}

/// One line "bmesh FILE tx ty tz qx qy qz qw". Stanford means the conjugate of the quaternion:
/// world = R(q)^T v + t.
ScanPose parse_bmesh(TextLines& lines, double mm_per_unit) {
    ScanPose pose;
    pose.file = std::string(lines.word());
    if (pose.file.empty()) lines.fail("expected 'bmesh FILE tx ty tz qx qy qz qw'");
    double n[7];
    for (double& value : n) value = lines.finite_number("one of tx ty tz qx qy qz qw");
    Eigen::Quaterniond q(n[6], n[3], n[4], n[5]);
    if (std::abs(q.norm() - 1) > 1e-3)
        lines.fail("expected a quaternion of length 1, found length " + std::to_string(q.norm()));
    pose.world_from_scan.rotation = q.normalized().conjugate().toRotationMatrix();
    pose.world_from_scan.translation = mm_per_unit * Eigen::Vector3d(n[0], n[1], n[2]);
    return pose;
}

std::vector<ScanPose> parse_conf(const std::string& text, const std::string& name,
                                 double mm_per_unit) {
    std::vector<ScanPose> poses;
    TextLines lines(text, name);
    while (lines.next()) {
        const std::string_view what = lines.word();
        if (what.empty() || what[0] == '#' || what == "camera") continue;
        if (what != "bmesh" && what != "mesh")
            lines.fail("expected 'bmesh', 'mesh' or 'camera', found '" + shown(what) + "'");
        poses.push_back(parse_bmesh(lines, mm_per_unit));
        if (!lines.word().empty()) lines.fail("expected the line to end after 7 numbers");
    }
    if (poses.empty()) throw FileError(name, "", "expected lines 'bmesh FILE ...', found none");
    return poses;
}

std::vector<ScanPose> parse_matrix(const std::string& text, const std::string& name,
                                   double mm_per_unit) {
    std::vector<double> numbers;
    TextLines lines(text, name, " \t,;[]");
    while (lines.next())
        for (std::string_view word = lines.word(); !word.empty() && word[0] != '#';
             word = lines.word()) {
            const auto value = parse_number(word);
            if (!value || !std::isfinite(*value))
                lines.fail("expected a finite number, found '" + shown(word) + "'");
            if (numbers.size() == 16) lines.fail("expected one 4x4 matrix, found more numbers");
            numbers.push_back(*value);
        }
    std::string why;
    auto motion = rigid_from_numbers(numbers, why);
    if (!motion) throw FileError(name, "", why);
    motion->translation *= mm_per_unit;
    ScanPose pose;
    pose.file = fs::path(name).filename().string();
    pose.world_from_scan = *motion;
    return {pose};
}

/// What tells a scan's path from others: without leading "..", and without the file names that are
/// the same in every scan folder of a project.
fs::path scan_name(const std::string& file) {
    fs::path path;
    for (const fs::path& part : fs::path(file).lexically_normal())
        if (part != ".." && part != ".") path /= part;
    const std::string last = path.filename().string();
    const bool is_common = last.empty() || last == "range.ply" || last == "recording.stria";
    return is_common && path.has_parent_path() ? path.parent_path() : path;
}

/// True if the shorter path is the end of the longer one, component by component.
bool is_tail(const fs::path& a, const fs::path& b) {
    auto i = a.end(), j = b.end();
    while (i != a.begin() && j != b.begin())
        if (*--i != *--j) return false;
    return a.begin() != a.end() && b.begin() != b.end();
}

}  // namespace

std::vector<ScanPose> parse_poses(const std::string& text, const std::string& name,
                                  double mm_per_unit) {
    const std::string ending = fs::path(name).extension().string();
    if (ending == ".toml") return parse_poses_toml(text, name);
    if (ending == ".conf") return parse_conf(text, name, mm_per_unit);
    return parse_matrix(text, name, mm_per_unit);
}

std::vector<ScanPose> read_poses(const std::string& path, double mm_per_unit) {
    return parse_poses(read_whole_file(path, std::size_t{64} << 20), path, mm_per_unit);
}

std::string format_poses(const std::vector<ScanPose>& poses) {
    std::string text;
    for (const ScanPose& pose : poses) {
        text += "[[scan]]\nfile = " + toml_text(pose.file) + "\n" +
                toml_matrix("world_from_scan", pose.world_from_scan);
        if (!pose.covariance.isZero(0))
            text += toml_matrix("covariance", Eigen::MatrixXd(pose.covariance));
        if (pose.fixed) text += "fixed = true\n";
        text += "\n";
    }
    return text;
}

void write_poses(const std::string& path, const std::vector<ScanPose>& poses) {
    write_whole_file(path, format_poses(poses));
}

const ScanPose& find_pose(const std::vector<ScanPose>& poses, const std::string& scan_path) {
    const fs::path wanted = scan_name(scan_path);
    const auto same_path = [&](const ScanPose& pose) { return scan_name(pose.file) == wanted; };
    const auto same_tail = [&](const ScanPose& pose) {
        return is_tail(scan_name(pose.file), wanted);
    };
    const auto same_stem = [&](const ScanPose& pose) {
        return scan_name(pose.file).stem() == wanted.stem();
    };
    const auto one_of = [&](const auto& fits) -> const ScanPose* {
        const auto first = std::find_if(poses.begin(), poses.end(), fits);
        if (first == poses.end()) return nullptr;
        const auto second = std::find_if(first + 1, poses.end(), fits);
        if (second != poses.end())
            throw Error("two poses fit the scan " + scan_path + ": '" + first->file + "' and '" +
                        second->file + "'");
        return &*first;
    };
    if (const ScanPose* pose = one_of(same_path)) return *pose;
    if (const ScanPose* pose = one_of(same_tail)) return *pose;
    if (const ScanPose* pose = one_of(same_stem)) return *pose;
    throw Error("no pose fits the scan " + scan_path +
                ": expected one with its path or its stem '" + wanted.stem().string() + "' among " +
                std::to_string(poses.size()) + " poses");
}

}  // namespace stria
