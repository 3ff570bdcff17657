#include <cmath>
#include <vector>

#include "host/geometry/fit.h"

int main() {
    const std::vector<Eigen::Vector3d> corners = {{0, 0, 2}, {1, 0, 2}, {0, 1, 2}, {1, 1, 2}};
    const stria::PlaneFit plane = stria::fit_plane(corners);
    return std::abs(std::abs(plane.offset_mm) - 2.0) < 1e-12 ? 0 : 1;
}
