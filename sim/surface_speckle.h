#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "sim/scene.h"

namespace stria {

/// Speckle as a pattern that sticks to the surfaces: a factor of the laser's light at a point of an
/// object, of mean 1, gamma distributed with shape 1 / contrast^2, correlated over length_mm, the
/// same in every frame. A normal field of B-splines on a lattice of random numbers in the object's
/// frame, brought to the gamma distribution point by point. Phenomenological: only the coherent
/// model (CoherentSurface) says what speckle does to a pulse over time.
class SurfaceSpeckle {
  public:
    /// @param speckle  of SpeckleModel::surface, valid
    SurfaceSpeckle(const SceneSpeckle& speckle, std::uint64_t seed);

    /// The factor at a point (mm, object frame).
    double at(int object, const Eigen::Vector3d& point_in_object) const;

    double lattice_mm() const { return lattice_mm_; }

  private:
    double normal_field(int object, const Eigen::Vector3d& point_in_object) const;

    std::uint64_t seed_;
    double lattice_mm_ = 1;
    std::vector<double> numbers_;  ///< normal quantiles, one by 12 random bits
    std::vector<double> gamma_;    ///< by normal deviate, evenly from -kMost to kMost
};

}  // namespace stria
