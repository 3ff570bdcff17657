#pragma once

namespace stria {

/// The program stria: parses, runs one verb, reports. Exit code 0 done, 1 it failed and said why,
/// 2 usage.
int run_program(int argc, const char* const* argv);

}  // namespace stria
