#include "host/cli/scan_input.h"

#include <Eigen/Geometry>
#include <cstdio>

#include "host/cli/progress.h"
#include "host/core/errors.h"
#include "host/io/range_io.h"

namespace stria {
namespace {

/// Length (mm) of the diagonal of the box around the points.
double extent_mm(const RangeImage& image) {
    Eigen::AlignedBox3d box;
    for (std::size_t cell = 0; cell < image.cell_count(); ++cell)
        if (image.mask[cell] != 0) box.extend(image.points[cell].position);
    return box.diagonal().norm();
}

void check_extent(const RangeImage& image, const std::string& path) {
    const double extent = extent_mm(image);
    if (valid_count(image) < 2 || (extent >= 2 && extent <= 20000)) return;
    char number[32];
    std::snprintf(number, sizeof number, "%.3g", extent);
    throw FileError(path, "",
                    std::string("the points span ") + number +
                        (extent < 2 ? " mm, expected at least 2; is the file in metres or inches? "
                                      "Say so with --unit m or --unit in"
                                    : " mm, expected at most 20000; is the file in micrometres? "
                                      "Say so with --unit um") +
                        " (--unit mm if it is right)");
}

}  // namespace

RangeImage read_range_scan(const ScanSource& source, const Context& context) {
    if (source.range.empty())
        throw FileError(source.name, "",
                        source.points.empty()
                            ? "expected a range image, found a recording alone; make it with "
                              "stria range"
                            : "expected a range image, found points without a grid");
    RangeImage image = read_range_image(source.range, context.mm_per_unit());
    if (valid_count(image) == 0)
        throw FileError(source.range, "", "expected points, found none in its grid");
    if (context.unit.empty()) check_extent(image, source.range);
    return image;
}

std::vector<ScanInput> read_range_scans(const std::vector<std::string>& arguments,
                                        const Context& context) {
    std::vector<ScanInput> inputs;
    const std::vector<ScanSource> sources = resolve_scans(arguments);
    Progress progress(context, "read", sources.size(), "scans");
    for (const ScanSource& source : sources) {
        inputs.push_back({source, read_range_scan(source, context)});
        progress.update(inputs.size());
    }
    return inputs;
}

}  // namespace stria
