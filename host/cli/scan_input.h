#pragma once
#include <string>
#include <vector>

#include "host/cli/command.h"
#include "host/core/range_image.h"
#include "host/project/project.h"

namespace stria {

/// The range images that the SCAN arguments name, read one by one.
struct ScanInput {
    ScanSource source;
    RangeImage image;
};

/// Reads the scan's range image. Throws FileError where there is none, for an image without points,
/// and for points that span less than 2 mm or more than 20 m while no --unit was given: then the
/// file's unit is hardly the millimetre.
RangeImage read_range_scan(const ScanSource& source, const Context& context);

/// Reads all scans that the arguments name, in their order, with progress.
std::vector<ScanInput> read_range_scans(const std::vector<std::string>& arguments,
                                        const Context& context);

}  // namespace stria
