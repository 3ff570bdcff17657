#pragma once
#include <vector>

#include "host/core/rigid3.h"
#include "host/core/tri_mesh.h"

/// The lumpy object of the tests from end to end, known in closed form to the program that makes
/// its recordings and to the test that measures it, which share nothing else.
namespace stria::test_support {

constexpr unsigned kMeasuredObject = 11;  ///< seed of make_bumpy_shape
constexpr int kMeasuredObjectViews = 9;

TriMesh measured_object();

/// world_from_object of each view: turned another way, some mm about the middle of the swept test
/// scanner's field.
std::vector<Rigid3> measured_object_poses();

}  // namespace stria::test_support
