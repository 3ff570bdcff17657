// A sweep of 8-bit frames: options, sensor, times and faults from the first bytes, pixels from the
// others. The fast analysis must find what the reference finds, within the bounds that
// firmware/stripe/README.md states, and the same bytes on every instruction set.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/firmware/stripe/byte_sweep.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stria::test;
    const auto found = disagreements(sweep_from_bytes(data, size));
    for (const Disagreement& one : found) std::fprintf(stderr, "%s\n", text_of(one).c_str());
    if (!found.empty()) std::abort();
    return 0;
}
