#pragma once
#include <Eigen/Core>
#include <random>
#include <string>
#include <vector>

#include "host/verify/artefact.h"
#include "host/verify/scan_points.h"
#include "host/verify/sphere_region.h"

namespace stria {

/// One number of a check artefact's shape, in mm.
struct ShapeFigure {
    std::string key;    ///< "diameter"
    std::string name;   ///< for people: "diameter of the sphere"
    double off_mm = 0;  ///< measured minus what the artefact's certificate states
};

/// The figures of a check artefact, "sphere" or "plane", nothing off.
std::vector<ShapeFigure> shape_figures(const std::string& kind);

/// What a scan makes of a check artefact's shape, and how well it can know that.
struct ShapeCheck {
    std::string kind;  ///< "sphere", "plane"
    std::vector<ShapeFigure> figures;
    /// Covariances of the figures (mm^2): noise of the points; errors that the calibration expects
    /// of itself; the artefact's own certificate.
    Eigen::MatrixXd noise, calibration, artefact;
};

/// The sphere's diameter (least squares, free radius, as probe_sphere()). The artefact's
/// uncertainty is that of its diameter. Throws stria::Error as probe_sphere(), and for a scan that
/// states no calibration errors.
/// @param artefact  with one diameter
ShapeCheck check_sphere(const ScanPoints& scan, const Artefact& artefact,
                        const SphereRegionOptions& options, std::mt19937& rng);

/// How a flat artefact bends: the least-squares quadric's height (mm) of its edges above its middle
/// along the longer and the shorter side, and of its corners by twist. The artefact's form error
/// counts as evenly distributed over its range. Throws stria::Error as measure_plane(), and for a
/// scan that states no calibration errors.
/// @param artefact  with size and margin
ShapeCheck check_plane(const ScanPoints& scan, const Artefact& artefact, std::mt19937& rng);

/// A check against what is expected of it.
struct Drift {
    std::vector<double> off_mm;       ///< of each figure, from the reference or the certificate
    std::vector<double> expected_mm;  ///< one standard deviation of it
    double p_value = 1;               ///< of all figures together (chi-square)
    /// Beyond 2 sigma: p below that of 2 standard deviations on either side of one normal figure.
    bool has_drifted() const { return p_value < 0.0455; }
};

/// @param reference  an earlier check of the same artefact with the same calibration: what it found
///                   off is expected again. Null: nothing off is expected. Where the artefact
///                   stood is not known, so the calibration's errors count in both checks; what the
///                   artefact itself is off cancels.
Drift judge_drift(const ShapeCheck& now, const ShapeCheck* reference = nullptr);

}  // namespace stria
