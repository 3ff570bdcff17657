#pragma once
#include <string>
#include <vector>

#include "host/advise/advise.h"

namespace stria {

/// One thing that could be changed, and what it would do: advice given again with it.
struct Change {
    std::string what;       ///< for people: "open the lens to f/5.6"
    double z_mm = 0;        ///< worst sigma_z over the depth then
    double gain = 0;        ///< share by which that is smaller than now; negative: worse
    double edge_ratio = 0;  ///< sigma_p / sigma_b in the middle then
    double seconds = 0;     ///< of a sweep then
};

/// What to change, the most useful first: lens a stop more open and more closed, power twice,
/// wavelength 450 nm, half the step or the advised one, waist at the mirror, a coat that
/// depolarises, an exposure that fits the brightest surface. Changes that cannot be made or change
/// nothing (below 0.5 %) are left out.
/// @param now  advise(scanner)
std::vector<Change> possible_changes(const AdvisedScanner& scanner, const Advice& now);

}  // namespace stria
