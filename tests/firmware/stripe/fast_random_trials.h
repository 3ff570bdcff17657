#pragma once
#include <cstdint>

namespace stria::test {

/// Analyses the random sweeps of seeds [begin, end), each third one with additive noise only, by
/// the reference and by the fast analysis; every broken bound is a failure that names its seed.
/// Prints how many pulses were compared.
void expect_no_broken_bound(std::uint64_t begin, std::uint64_t end);

}  // namespace stria::test
