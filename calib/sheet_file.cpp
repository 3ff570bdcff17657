#include "calib/sheet_file.h"

#include "host/io/camera_toml.h"
#include "host/io/number_text.h"
#include "host/io/toml_text.h"
#include "host/io/whole_file.h"

namespace stria {

std::string format_sheet(const MeasuredSheet& sheet) {
    return "[camera]\n" + format_camera_keys(sheet.camera) + "\n[sheet]\n" +
           toml_line("normal", sheet.normal) + "offset_mm = " + toml_number(sheet.offset_mm) +
           "\n" + toml_matrix("covariance", Eigen::MatrixXd(sheet.covariance));
}

MeasuredSheet parse_sheet(const std::string& text, const std::string& name) {
    TomlTable top = parse_toml(text, name);
    MeasuredSheet sheet;
    TomlTable camera = top.table("camera");
    sheet.camera = read_camera_keys(camera);
    TomlTable table = top.table("sheet");
    sheet.normal = read_unit_vector(table, "normal");
    sheet.offset_mm = table.number("offset_mm");
    if (!(sheet.offset_mm > 0)) table.refuse("offset_mm", "expected above 0");
    const std::vector<double> numbers = table.numbers("covariance", 16);
    sheet.covariance =
        Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
    const double size = sheet.covariance.cwiseAbs().maxCoeff();
    if (!sheet.covariance.isApprox(sheet.covariance.transpose(), 1e-9) ||
        sheet.covariance.diagonal().minCoeff() < -1e-12 * size)
        table.refuse("covariance", "expected a symmetric matrix without negative variances");
    top.finish();
    return sheet;
}

MeasuredSheet read_sheet(const std::string& path) {
    return parse_sheet(read_whole_file(path, std::size_t{1} << 20), path);
}

void write_sheet(const std::string& path, const MeasuredSheet& sheet) {
    write_whole_file(path, format_sheet(sheet));
}

}  // namespace stria
