#pragma once
#include "host/core/scanner_model.h"

/// Scanners with plausible layouts, for tests: camera 640 x 512, 0.3 mm a pixel at 450 mm, laser
/// 180 mm to its right.
namespace stria::test_support {

ScannerModel swept_scanner();
ScannerModel rail_scanner();
ScannerModel turntable_scanner();

}  // namespace stria::test_support
