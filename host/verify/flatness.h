#pragma once
#include <Eigen/Core>
#include <random>
#include <vector>

#include "host/verify/artefact.h"
#include "host/verify/plane_patch.h"
#include "host/verify/residuals.h"
#include "host/verify/scan_points.h"

namespace stria {

/// A flat artefact as measured, with the least-squares plane.
struct MeasuredPlane {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();   ///< middle of the measured patch, mm
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< towards the camera where it is known
    Eigen::Vector3d along = Eigen::Vector3d::UnitX();   ///< unit, of the patch's longer side
    Eigen::Vector2d size_mm{0, 0};  ///< of the patch as found, longer side first
    Eigen::Vector2d used_mm{0, 0};  ///< what is left of it inside the margin
    double incidence_rad = 0;       ///< of the line of sight at the middle; NaN: not known
    FormFigures form;               ///< F is form.form_mm
    ScanPoints points;              ///< those that count
    std::size_t beside = 0;  ///< points near the plane that belong to other things, or next to
    double pitch_mm = 0;     ///< median distance of neighbouring points
};

/// Finds the flat artefact among other planes by its size (each side between half and 1.05 of the
/// calibrated one), grows its patch, and measures the flatness F following VDI/VDE 2634-2: least
/// squares, three in a thousand rejected, greatest minus least distance. Groups of many points
/// off the plane, mostly farther than kPlaneShell, and what is next to them, are other things; all
/// other points off it count. Throws
/// stria::Error with the sizes of the planes that were found instead.
MeasuredPlane measure_plane(const ScanPoints& scan, const PlaneSearch& search, std::mt19937& rng);

}  // namespace stria
