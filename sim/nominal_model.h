#pragma once
#include "host/core/scanner_model.h"
#include "sim/scene.h"

namespace stria {

/// The geometry that frames are rendered with.
ScannerModel truth_model(const Scene& scene);

/// The machine as designed: the truth moved by seeded errors as [nominal] says. The design knows no
/// lens distortion, bow, non-linearity or delay, and takes the image's centre for the principal
/// point.
ScannerModel nominal_model(const Scene& scene, std::uint64_t seed);

}  // namespace stria
