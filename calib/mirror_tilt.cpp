#include "calib/mirror_tilt.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace stria {
namespace {

constexpr double kWorthFollowing = 8;  // half chi-square of few points that all may turn over
constexpr int kFewPoints = 80;         // a view
constexpr double kElsewhere = 0.1;     // of the tilt tried: what ends nearer has come back

double tilt_of(const ScannerProblem& problem) {
    const MirrorAxis& mirror = problem.channels().front().axis.mirror;
    return std::asin(std::clamp(mirror.normal0.dot(mirror.direction), -1.0, 1.0));
}

void tilt_mirror(ScannerProblem& problem, double by_rad) {
    const CameraModel camera = problem.channels().front().camera;
    AxisModel axis = problem.channels().front().axis;
    Eigen::Vector3d& m0 = axis.mirror.normal0;
    const Eigen::Vector3d aside = m0.cross(axis.mirror.direction).normalized();
    m0 = Eigen::AngleAxisd(by_rad, aside) * m0;
    problem.set_camera_and_axis(camera, axis);
}

/// Quick to solve: what does not settle soon is no minimum near.
ScannerProblem::Stage of_few_points(const ScannerProblem::Stage& all,
                                    const ScannerProblem& problem) {
    std::size_t points = 0;
    for (const ScannerProblem::View& view : problem.views) points += view.stripes.size();
    ScannerProblem::Stage stage = all;
    stage.every = std::max(1, static_cast<int>(points / (kFewPoints * problem.views.size())));
    stage.max_iterations = 30;
    stage.valley_iterations = 0;
    return stage;
}

/// Camera and poses stay as they are.
ScannerProblem::Stage stripes_alone(ScannerProblem::Stage stage) {
    stage.camera = stage.corners = false;
    return stage;
}

/// The same while m0 stays.
ScannerProblem::Stage mirror_held(ScannerProblem::Stage stage) {
    std::vector<int>& free = stage.axis_free;
    free.erase(std::remove_if(free.begin(), free.end(),
                              [](int entry) { return entry == 4 || entry == 5; }),
               free.end());
    return stage;
}

}  // namespace

OtherMirror take_better_mirror(ScannerProblem& problem, const ScannerProblem::Stage& all,
                               double tilt_rad) {
    OtherMirror result;
    if (problem.channels().front().axis.kind != MachineKind::swept) return result;
    const double tilt = tilt_of(problem);
    const auto came_back = [&](const ScannerProblem& other) {
        return std::abs(tilt_of(other) - tilt) < kElsewhere * tilt_rad;
    };
    const ScannerProblem::Stage few = of_few_points(all, problem);
    const double few_cost = ScannerProblem(problem).solve(few).final_cost;
    for (const double way : {1.0, -1.0}) {
        ScannerProblem other = problem;
        tilt_mirror(other, way * tilt_rad);
        other.solve(mirror_held(stripes_alone(few)));
        other.solve(stripes_alone(few));
        if (came_back(other)) continue;
        const double cost = other.solve(few).final_cost;
        if (came_back(other) || cost > few_cost + kWorthFollowing) continue;
        const double margin = other.solve(all).final_cost - problem.cost(all);
        if (came_back(other)) continue;
        result.margin = std::abs(margin);
        if (margin >= 0) continue;
        result.taken = true;
        problem = std::move(other);
        break;
    }
    return result;
}

}  // namespace stria
