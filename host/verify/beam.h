#pragma once
#include <Eigen/Core>
#include <random>
#include <vector>

#include "host/verify/artefact.h"
#include "host/verify/probing.h"

namespace stria {

/// A ball bar, or a beam of more spheres on a line, as one scan shows it.
struct MeasuredBeam {
    std::vector<MeasuredSphere> fixed;  ///< in the artefact's order, radius as calibrated
    std::vector<MeasuredSphere> free;   ///< the same spheres and points, free radius
};

/// Finds the artefact's spheres and tells which is which: along their line, and where both ways
/// fit by their diameters. Throws stria::Error that says what was found instead: fewer or more
/// spheres, another diameter, centres whose distances differ from the artefact's by more than 2 %.
/// @param artefact  with n diameters and n - 1 lengths
MeasuredBeam measure_beam(const ScanPoints& scan, const Artefact& artefact,
                          const SphereRegionOptions& options, std::mt19937& rng);

/// A length between two spheres of a beam.
struct BeamLength {
    std::size_t from = 0, to = 0;
    double calibrated_mm = 0;
    double measured_mm = 0;
    double expanded_mm = 0;  ///< U of the test (k = 2): calibration, temperature, fit
    double error_mm() const { return measured_mm - calibrated_mm; }
};

/// Distance of the centres, spheres of given radius: the sphere-spacing error SD of VDI/VDE 2634-2.
BeamLength centre_distance(const MeasuredBeam& beam, const Artefact& artefact, std::size_t from,
                           std::size_t to);
/// Length over both spheres, centres and diameters as measured with free radius: a length that
/// errs with the size of what it ends on, as a calliper's does (bidirectional).
BeamLength length_over(const MeasuredBeam& beam, const Artefact& artefact, std::size_t from,
                       std::size_t to);

}  // namespace stria
