#include "host/cli/scan_notes.h"

#include <vector>

#include "host/io/toml_file.h"
#include "host/io/toml_text.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

constexpr std::size_t kMostBytes = 1 << 20;

Eigen::MatrixXd read_square(TomlTable& table, const std::string& key, std::size_t side) {
    const std::vector<double> numbers = table.numbers(key, side * side);
    Eigen::MatrixXd matrix(static_cast<Eigen::Index>(side), static_cast<Eigen::Index>(side));
    for (std::size_t i = 0; i < numbers.size(); ++i)
        matrix(static_cast<Eigen::Index>(i / side), static_cast<Eigen::Index>(i % side)) =
            numbers[i];
    for (Eigen::Index i = 0; i < matrix.rows(); ++i)
        if (!(matrix(i, i) >= 0)) table.refuse(key, "expected no negative variance");
    return matrix;
}

ShapeCheck read_check(TomlTable& table) {
    ShapeCheck check;
    check.kind = table.text("kind");
    if (check.kind != "sphere" && check.kind != "plane")
        table.refuse("kind", "expected sphere or plane, found '" + check.kind + "'");
    check.figures = shape_figures(check.kind);
    const std::vector<double> off = table.numbers("off_mm", check.figures.size());
    for (std::size_t i = 0; i < off.size(); ++i) check.figures[i].off_mm = off[i];
    check.noise = read_square(table, "noise_mm2", off.size());
    check.calibration = read_square(table, "calibration_mm2", off.size());
    check.artefact = read_square(table, "artefact_mm2", off.size());
    return check;
}

}  // namespace

std::string format_scan_notes(const ScanNotes& notes) {
    std::string text = "[scan]\n" + toml_line("model_hash", notes.model_hash);
    if (notes.temperature_c) text += toml_line("temperature_c", *notes.temperature_c);
    if (!notes.check) return text;
    std::vector<double> off;
    for (const ShapeFigure& figure : notes.check->figures) off.push_back(figure.off_mm);
    return text + "\n[check]\n" + toml_line("artefact", notes.artefact) +
           toml_line("kind", notes.check->kind) + toml_line("off_mm", off) +
           toml_matrix("noise_mm2", notes.check->noise) +
           toml_matrix("calibration_mm2", notes.check->calibration) +
           toml_matrix("artefact_mm2", notes.check->artefact);
}

ScanNotes parse_scan_notes(const std::string& text, const std::string& name) {
    TomlTable top = parse_toml(text, name);
    ScanNotes notes;
    TomlTable scan = top.table("scan");
    notes.model_hash = scan.text("model_hash");
    if (scan.has("temperature_c")) notes.temperature_c = scan.number("temperature_c");
    if (auto check = top.find_table("check")) {
        notes.artefact = check->text("artefact");
        notes.check = read_check(*check);
    }
    top.finish();
    return notes;
}

ScanNotes read_scan_notes(const std::string& path) {
    return parse_scan_notes(read_whole_file(path, kMostBytes), path);
}

}  // namespace stria
