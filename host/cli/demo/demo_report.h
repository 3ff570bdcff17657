#pragma once
#include <string>

#include "host/cli/demo/demo_run.h"

namespace stria {

/// Writes the demo's page: stripe and range images, convergence, error map on the mesh, predicted
/// against actual sigma, time and memory of every stage.
void write_demo_report(const std::string& path, const DemoResult& result, unsigned seed);

}  // namespace stria
