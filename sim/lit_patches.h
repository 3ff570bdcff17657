#pragma once
#include <Eigen/Core>
#include <vector>

#include "sim/beam.h"
#include "sim/scene_geometry.h"

namespace stria {

/// A piece of surface that the sheet lights during a stretch of its sweep, or several such pieces
/// seen as one. World frame, mm.
struct LitPatch {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();       ///< mean by power
    Eigen::Vector3d on_surface = Eigen::Vector3d::Zero();  ///< of its strongest piece
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();    ///< mean by power: shorter than 1 if bent
    Eigen::Vector3d to_light = Eigen::Vector3d::Zero();  ///< unit, of the strongest piece
    Eigen::Vector3d half_a = Eigen::Vector3d::Zero();    ///< of a single piece: point +- half_a
    Eigen::Vector3d half_b = Eigen::Vector3d::Zero();    ///< +- half_b are its corners
    double radius_mm = 0;                                ///< about `point`
    /// Power scattered evenly, and sent into the glossy lobe, summed over the sweep: mW at laser
    /// power 1 times the unit of s.
    double diffuse = 0, specular = 0;
    double gloss = 1;
    double s_low = 0, s_high = 0;  ///< when the sheet's centre is on it
    double s_sigma = 0;            ///< one beam width, in s
};

/// The surface that a swept sheet lights, cut along s and along the fan and gathered in a pyramid:
/// level 0 holds the pieces, each level above joins two by two, the last one is the whole. So that
/// a far part counts as one light and a near one as its pieces (Walter and others 2005,
/// "Lightcuts", with the surface's own order for the tree).
class LitPatches {
  public:
    LitPatches(const Beam& beam, const SceneGeometry& geometry, const SceneAxis& axis);

    int levels() const { return static_cast<int>(levels_.size()); }
    int side(int level) const { return side_ >> level; }
    const LitPatch& at(int level, int i, int j) const {
        const auto n = static_cast<std::size_t>(side(level));
        return levels_[static_cast<std::size_t>(level)]
                      [static_cast<std::size_t>(i) * n + static_cast<std::size_t>(j)];
    }

  private:
    int side_ = 0;
    std::vector<std::vector<LitPatch>> levels_;  ///< [level][s x side + fan]
};

}  // namespace stria
