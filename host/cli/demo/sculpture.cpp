#include "host/cli/demo/sculpture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "host/core/rigid3.h"

namespace stria {
namespace {

using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;
constexpr double kFacetMm = 0.8;  // chord error of a 16 mm ball: 0.005 mm
constexpr float kLight = 0.8F;
constexpr float kDark = 0.16F;  // 5:1

/// Grid of nu x nv points from a function on [0, 1]^2; closed in u and/or v by repeated indices.
/// Triangles turn so that du x dv points outwards.
void add_patch(TriMesh& mesh, int nu, int nv, bool closed_u, bool closed_v,
               const std::function<Vector3d(double, double)>& surface) {
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    const int columns = closed_u ? nu : nu + 1;
    const int rows = closed_v ? nv : nv + 1;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i)
            mesh.positions.push_back(
                surface(static_cast<double>(i) / nu, static_cast<double>(j) / nv));
    const auto at = [&](int i, int j) {
        return base + static_cast<std::uint32_t>((j % rows) * columns + i % columns);
    };
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        const Vector3d &p = mesh.positions[a], &q = mesh.positions[b], &r = mesh.positions[c];
        if ((q - p).cross(r - p).norm() > 1e-12) mesh.triangles.push_back({a, b, c});  // poles
    };
    for (int j = 0; j < nv; ++j)
        for (int i = 0; i < nu; ++i) {
            add(at(i, j), at(i + 1, j), at(i + 1, j + 1));
            add(at(i, j), at(i + 1, j + 1), at(i, j + 1));
        }
}

int steps(double length_mm) {
    return std::max(1, static_cast<int>(std::ceil(length_mm / kFacetMm)));
}

/// Closed box; each face a patch of its own, so edges stay sharp.
TriMesh box(const Vector3d& half, const Rigid3& object_from_box) {
    TriMesh mesh;
    for (int axis = 0; axis < 3; ++axis)
        for (double side : {-1.0, 1.0}) {
            const int a = (axis + 1) % 3, b = (axis + 2) % 3;
            add_patch(mesh, steps(2 * half[a]), steps(2 * half[b]), false, false,
                      [&](double u, double v) -> Vector3d {
                          if (side < 0) u = 1 - u;
                          Vector3d p;
                          p[axis] = side * half[axis];
                          p[a] = (2 * u - 1) * half[a];
                          p[b] = (2 * v - 1) * half[b];
                          return object_from_box * p;
                      });
        }
    return mesh;
}

/// Ellipsoid whose surface is moved along its normal by relief(unit direction), mm.
TriMesh ellipsoid(const Vector3d& centre, const Vector3d& radii,
                  const std::function<double(const Vector3d&)>& relief) {
    TriMesh mesh;
    const int around = steps(2 * kPi * radii.maxCoeff());
    add_patch(mesh, around, around / 2, true, false, [&](double u, double v) -> Vector3d {
        // v from the south to the north pole, u counter-clockwise seen from +y
        const double azimuth = 2 * kPi * u, height = kPi * (v - 0.5);
        const bool pole = v < 1e-9 || v > 1 - 1e-9;
        const double ring = pole ? 0.0 : std::cos(height);
        const Vector3d unit(ring * std::cos(azimuth), std::sin(height), -ring * std::sin(azimuth));
        const Vector3d normal = unit.cwiseQuotient(radii).normalized();
        return centre + unit.cwiseProduct(radii) + relief(unit) * normal;
    });
    return mesh;
}

TriMesh torus(const Rigid3& object_from_torus, double ring_mm, double tube_mm) {
    TriMesh mesh;
    add_patch(mesh, steps(2 * kPi * (ring_mm + tube_mm)), steps(2 * kPi * tube_mm), true, true,
              [&](double u, double v) -> Vector3d {
                  const double a = 2 * kPi * u, b = 2 * kPi * v;
                  const double r = ring_mm + tube_mm * std::cos(b);
                  return object_from_torus *
                         Vector3d(r * std::cos(a), r * std::sin(a), tube_mm * std::sin(b));
              });
    return mesh;
}

/// Solid of revolution about y through `centre`: profile of (radius, y), from the axis back to the
/// axis, counter-clockwise in the (radius, y) half plane so that the normals point outwards.
TriMesh revolved(const Vector3d& centre, const std::vector<Eigen::Vector2d>& profile) {
    TriMesh mesh;
    double widest = 0;
    for (const auto& p : profile) widest = std::max(widest, p.x());
    for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
        const Eigen::Vector2d from = profile[k], to = profile[k + 1];
        add_patch(mesh, steps(2 * kPi * widest), steps((to - from).norm()), true, false,
                  [&](double u, double v) -> Vector3d {
                      const Eigen::Vector2d p = (1 - v) * from + v * to;
                      const double a = 2 * kPi * u;
                      return centre + Vector3d(p.x() * std::cos(a), p.y(), -p.x() * std::sin(a));
                  });
    }
    return mesh;
}

/// Cup: rounded rim, hollow.
std::vector<Eigen::Vector2d> cup_profile() {
    constexpr double kOuter = 22, kInner = 17, kTop = 26, kFloor = 4;
    std::vector<Eigen::Vector2d> profile = {{0, 0}, {kOuter, 0}, {kOuter, kTop}};
    const double rim = 0.5 * (kOuter - kInner);
    for (int i = 1; i <= 12; ++i) {
        const double a = kPi * i / 12;
        profile.emplace_back(0.5 * (kOuter + kInner) + rim * std::cos(a), kTop + rim * std::sin(a));
    }
    for (int i = 0; i <= 12; ++i) {  // the floor is a quarter round, then flat
        const double a = 0.5 * kPi * i / 12;
        profile.emplace_back(kInner - 6 + 6 * std::cos(a), kFloor + 6 - 6 * std::sin(a));
    }
    profile.emplace_back(0, kFloor);
    return profile;
}

const Vector3d kBodyCentre(0, -4, 0), kBodyRadii(38, 54, 33);
constexpr double kReliefRad = 0.55;  // radius of the patch

double from_relief_centre(const Vector3d& direction) {
    return std::acos(std::clamp(direction.dot(Vector3d(0.2, 0.1, 1).normalized()), -1.0, 1.0));
}
bool in_relief(const Vector3d& direction) { return from_relief_centre(direction) < kReliefRad; }

/// Fine relief on the body's front: ripples that fade out at the patch's border.
double relief_mm(const Vector3d& direction) {
    if (!in_relief(direction)) return 0;
    const double fade = 0.5 + 0.5 * std::cos(kPi * from_relief_centre(direction) / kReliefRad);
    return 0.5 * fade * std::sin(direction.x() * 42) * std::sin(direction.y() * 34);
}

/// Bands, dots and a dark foot: light and dark meet at sharp borders on every part.
float pattern(const Vector3d& p) {
    const bool band = std::fmod(p.y() + 0.4 * p.x() + 1000, 28.0) < 9.0;
    const Vector3d cell = (p / 17.0).array().round() * 17.0;
    const bool dot = (p - cell).norm() < 4.0;
    return band != dot ? kDark : kLight;
}

Rigid3 placed(const Vector3d& turn, const Vector3d& at) { return {rotation_from_vector(turn), at}; }

}  // namespace

std::vector<SculpturePart> make_sculpture() {
    const auto none = [](const Vector3d&) { return 0.0; };
    std::vector<SculpturePart> parts;
    parts.push_back({"plinth", box({52, 11, 38}, placed({0, 0.15, 0}, {0, -60, 0}))});
    parts.push_back({"body", ellipsoid(kBodyCentre, kBodyRadii, relief_mm)});
    parts.push_back({"ball", ellipsoid({-46, -32, 8}, {19, 19, 19}, none)});
    parts.push_back({"ring", torus(placed({0, 0.3, 0}, {-42, 20, 0}), 19, 6)});
    parts.push_back({"cup", revolved({2, 42, -2}, cup_profile())});
    parts.push_back({"wall", box({20, 22, 1.0}, placed({0, -0.4, 0}, {50, 12, 4}))});
    parts.push_back({"wedge", box({14, 14, 14}, placed({0.5, 0.3, 0.6}, {38, -44, 20}))});
    for (SculpturePart& part : parts) {
        VertexAttribute albedo{"albedo", 1, {}}, relief{"relief", 1, {}};
        for (const Vector3d& p : part.mesh.positions) {
            albedo.values.push_back(pattern(p));
            const Vector3d direction = (p - kBodyCentre).cwiseQuotient(kBodyRadii).normalized();
            relief.values.push_back(part.name == "body" && in_relief(direction) ? 1.0F : 0.0F);
        }
        part.mesh.attributes = {std::move(albedo), std::move(relief)};
    }
    return parts;
}

TriMesh merged(const std::vector<SculpturePart>& parts) {
    TriMesh all;
    all.attributes = {{"albedo", 1, {}}, {"relief", 1, {}}};
    for (const SculpturePart& part : parts) {
        const auto base = static_cast<std::uint32_t>(all.positions.size());
        all.positions.insert(all.positions.end(), part.mesh.positions.begin(),
                             part.mesh.positions.end());
        for (const auto& t : part.mesh.triangles)
            all.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
        for (std::size_t a = 0; a < all.attributes.size(); ++a) {
            const auto& from = part.mesh.attributes[a].values;
            auto& into = all.attributes[a].values;
            into.insert(into.end(), from.begin(), from.end());
        }
    }
    return all;
}

}  // namespace stria
