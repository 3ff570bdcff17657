#include "host/cli/demo/sculpture.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

#include "host/cli/demo/demo_measure.h"
#include "host/cli/demo/sculpture_truth.h"

namespace stria {
namespace {

using Eigen::Vector3d;

const std::vector<SculpturePart>& parts() {
    static const std::vector<SculpturePart> made = make_sculpture();
    return made;
}
const SculptureTruth& truth() {
    static const SculptureTruth made(parts());
    return made;
}
const SculpturePart& part(const std::string& name) {
    return *std::find_if(parts().begin(), parts().end(),
                         [&](const SculpturePart& p) { return p.name == name; });
}
double volume(const TriMesh& mesh) {
    double sum = 0;
    for (const auto& t : mesh.triangles)
        sum += mesh.positions[t[0]].dot(mesh.positions[t[1]].cross(mesh.positions[t[2]])) / 6;
    return sum;
}

TEST(Sculpture, SolidsHaveTheirClosedFormVolumes) {
    constexpr double kPi = std::numbers::pi;
    EXPECT_NEAR(volume(part("plinth").mesh), 8.0 * 52 * 11 * 38, 1e-6);
    EXPECT_NEAR(volume(part("wall").mesh), 8.0 * 20 * 22 * 1, 1e-6);
    // inscribed facets of 0.8 mm take some parts in a thousand away
    EXPECT_NEAR(volume(part("ball").mesh) / (4.0 / 3.0 * kPi * 19 * 19 * 19), 1, 3e-3);
    EXPECT_NEAR(volume(part("ring").mesh) / (2 * kPi * kPi * 19 * 36), 1, 5e-3);
}

TEST(Sculpture, IsPaintedFiveToOne) {
    const auto& albedo = truth().mesh().find_attribute("albedo")->values;
    const auto [low, high] = std::minmax_element(albedo.begin(), albedo.end());
    EXPECT_NEAR(*high / *low, 5.0, 1e-6);
}

TEST(SculptureTruth, ErrorAlongIsPositiveInItsDirection) {
    const Vector3d ball(-46, -32, 8), out = Vector3d(-1, -0.1, 0.2).normalized();
    for (double e : {-0.3, -0.01, 0.02, 0.5}) {
        const auto found = truth().error_along(ball + (19 + e) * out, out, 2.0);
        ASSERT_TRUE(found);
        EXPECT_NEAR(*found, e, 0.006);  // mm: the facets' sagitta
    }
    EXPECT_FALSE(truth().error_along(ball + 40 * out, out, 2.0));
}

TEST(SculptureTruth, CreasesAreEdgesAndMeetingLines) {
    // On the wall's face, 5 mm from its outer edge; the face is x along the wall, y up.
    const Rigid3 wall = {rotation_from_vector({0, -0.4, 0}), Vector3d(50, 12, 4)};
    const Vector3d inside = wall * Vector3d(15, 0, 1), outside = wall * Vector3d(19.5, 0, 1);
    EXPECT_TRUE(truth().is_near_crease(inside, 5.15));  // mm: the edge is a row of points
    EXPECT_FALSE(truth().is_near_crease(inside, 4.95));
    EXPECT_TRUE(truth().is_near_crease(outside, 0.65));
    EXPECT_FALSE(truth().is_near_crease(outside, 0.45));
    const Vector3d ball_far_side = Vector3d(-46, -32, 8) + 19 * Vector3d(-1, 0, 0);
    EXPECT_FALSE(truth().is_near_crease(ball_far_side, 5));
}

TEST(SculptureTruth, SeesTheFrontOnly) {
    TrueView view;
    view.camera = {0, 0, 460};
    view.laser = {180, 0, 440};
    view.camera_from_object = {Eigen::Vector3d(1, -1, -1).asDiagonal(), Vector3d(0, 0, 460)};
    view.half_field_x = view.half_field_y = 0.25;
    const Vector3d front(0, -4, 33), back(0, -4, -33);
    EXPECT_TRUE(truth().is_seen(truth().nearest(front).point, {0, 0, 1}, {view}));
    EXPECT_FALSE(truth().is_seen(truth().nearest(back).point, {0, 0, -1}, {view}));
    view.half_field_x = 1e-4;
    EXPECT_FALSE(truth().is_seen({20, -4, 28}, {0, 0, 1}, {view}));
}

TEST(SculptureTruth, FitFindsTheMotionBack) {
    std::vector<Vector3d> points;
    const Rigid3 away = {rotation_from_vector({0.004, -0.003, 0.005}), Vector3d(0.4, -0.3, 0.2)};
    for (const auto& sample : truth().samples(20000, 3))
        points.push_back(away.inverse() * sample.point);
    const Rigid3 found = fit_to_truth(truth(), points, {});
    for (const Vector3d& p : {Vector3d(70, 0, 0), Vector3d(0, 70, 0), Vector3d(0, 0, 45)})
        EXPECT_LT((found * p - away * p).norm(), 1e-3);  // mm: interiors of parts match as well
}

TEST(DemoMeasure, FiguresOfAKnownList) {
    std::vector<double> distances;
    for (int i = 0; i <= 100; ++i) distances.push_back(i);
    const ErrorFigures figures = error_figures(distances);
    EXPECT_EQ(figures.mean_mm, 50);
    EXPECT_EQ(figures.p95_mm, 95);
    EXPECT_EQ(figures.p99_mm, 99);
    EXPECT_EQ(figures.max_mm, 100);
    EXPECT_NEAR(figures.rms_mm, std::sqrt(3350.0), 1e-9);
}

TEST(DemoMeasure, TheTruthMovedHasItsOwnError) {
    // The outer shell itself, moved out along its normals by 0.05 mm, is 0.05 mm off where seen.
    TriMesh shell = part("ball").mesh;
    for (Vector3d& p : shell.positions) p += 0.05 * (p - Vector3d(-46, -32, 8)).normalized();
    TrueView view;
    view.camera = {-460, -32, 8};
    view.laser = {-440, -32, 180};
    view.camera_from_object.rotation << 0, 0, 1, 0, -1, 0, 1, 0, 0;
    view.camera_from_object.translation = -(view.camera_from_object.rotation * view.camera);
    view.half_field_x = view.half_field_y = 0.3;
    const auto compared = compare_with_truth(shell, truth(), {view}, {}, 1);
    EXPECT_GT(compared.mesh_to_truth.count, 1000U);
    EXPECT_NEAR(compared.mesh_to_truth.mean_mm, 0.05, 0.02);  // the fit shares it out
}

}  // namespace
}  // namespace stria
