#pragma once
#include <Eigen/Core>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "host/verify/artefact.h"
#include "host/verify/find_spheres.h"
#include "host/verify/residuals.h"
#include "host/verify/sphere_region.h"

namespace stria {

/// One sphere as measured: its least-squares sphere, of free or of given radius.
struct MeasuredSphere {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< mm, scan frame
    double diameter_mm = 0;
    Eigen::Matrix3d centre_covariance = Eigen::Matrix3d::Zero();  ///< mm^2, see diameter_sigma_mm
    /// One standard deviation from the points' scatter about the fit, taken as independent from
    /// point to point: errors that neighbours share make it larger. 0 for a given radius.
    double diameter_sigma_mm = 0;
    FormFigures form;  ///< PF is form.form_mm
    SphereRegion region;
    ScanPoints points;                                  ///< those of the region, in its order
    Eigen::Vector3d middle = Eigen::Vector3d::UnitZ();  ///< mean direction of the points, unit
    double cap_rad = 0;                                 ///< greatest angle between it and a point
    double coverage = 0;  ///< share of the whole sphere that has points, 0..1
};

/// Least-squares sphere through a region, its form and uncertainty: fitted to all points, then
/// again without the three in a thousand farthest from it. Throws stria::Error for fewer than 100
/// points.
/// @param diameter_mm  empty: free; else the fit seeks the centre alone
MeasuredSphere measure_sphere(const ScanPoints& scan, const SphereRegion& region,
                              std::optional<double> diameter_mm = {});

/// Probing error of one position.
struct ProbingPosition {
    MeasuredSphere sphere;
    double size_mm = 0;           ///< PS: measured minus calibrated diameter
    double size_expanded_mm = 0;  ///< U of the test (k = 2): calibration, temperature, fit
};

/// Finds the artefact's sphere in the scan and measures it, following the procedure of VDI/VDE
/// 2634-2 for the probing errors of form and size (least squares, free radius, three in a thousand
/// rejected). Throws stria::Error that says what was found instead: no sphere, another diameter,
/// several spheres, too noisy.
/// @param artefact  with one diameter
ProbingPosition probe_sphere(const ScanPoints& scan, const Artefact& artefact,
                             const SphereRegionOptions& options, std::mt19937& rng);

/// Throws stria::Error unless noise and diameter of a found sphere suit the calibrated one: within
/// 5 % of the diameter, standard deviation below a hundredth of the radius.
void check_found(const FoundSphere& found, double calibrated_diameter_mm);

}  // namespace stria
