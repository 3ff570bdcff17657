#include "sim/lit_patches.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "firmware/core/median.h"
#include "host/geometry/parallel.h"

namespace stria {
namespace {

constexpr int kFewest = 64, kMost = 512;  ///< pieces along s and along the fan, powers of two
constexpr double kBeamWidths = 1.5;       ///< of s that a piece should span
constexpr double kBeyondTravel = 0.05;    ///< of the travel: the drive runs up and out
constexpr double kLongestPiece = 8;       ///< times as long as wide; grazed surface is cut off

struct Cell {
    double s = 0, s_half = 0, phi = 0, phi_half = 0;
};

/// The power of one cell of (s, phi) where its middle ray meets the scene.
LitPatch single_piece(const Beam& beam, const SceneGeometry& geometry, const Cell& cell) {
    LitPatch patch;
    const BeamRay ray = beam.ray(cell.s, cell.phi);
    if (!(ray.mw_per_rad > 0)) return patch;
    const SurfaceHit hit = geometry.first_hit(ray.origin, ray.direction);
    if (hit.object < 0 || hit.albedo + hit.specular <= 0) return patch;
    const auto passing = beam.passing(hit, cell.s);
    if (!passing) return patch;
    const Eigen::Vector3d normal = hit.normal.cast<double>();
    const auto on_tangent_plane = [&](double s, double phi) -> Eigen::Vector3d {
        const BeamRay other = beam.ray(s, phi);
        return other.origin +
               normal.dot(hit.point - other.origin) / normal.dot(other.direction) * other.direction;
    };
    patch.half_a = (on_tangent_plane(cell.s, cell.phi + cell.phi_half) -
                    on_tangent_plane(cell.s, cell.phi - cell.phi_half)) /
                   2;
    patch.half_b = (on_tangent_plane(cell.s + cell.s_half, cell.phi) -
                    on_tangent_plane(cell.s - cell.s_half, cell.phi)) /
                   2;
    const double a = patch.half_a.norm(), b = patch.half_b.norm();
    const double longest =
        kLongestPiece * (hit.point - ray.origin).norm() * std::max(2 * cell.s_half, cell.phi_half);
    if (!(a > 0 && b > 0 && a < longest && b < longest)) return patch;
    const double power = ray.mw_per_rad * 2 * cell.phi_half * 2 * cell.s_half;
    patch.point = patch.on_surface = hit.point;
    patch.normal = normal;
    patch.to_light = -ray.direction;
    patch.radius_mm = std::hypot(a, b);
    patch.diffuse = power * static_cast<double>(hit.albedo);
    patch.specular = power * static_cast<double>(hit.specular);
    patch.gloss = static_cast<double>(hit.gloss);
    patch.s_low = cell.s - cell.s_half;
    patch.s_high = cell.s + cell.s_half;
    patch.s_sigma = 1 / passing->per_s;
    return patch;
}

LitPatch joined(const LitPatch* const (&parts)[4]) {
    LitPatch whole;
    double power = 0, strongest = 0;
    for (const LitPatch* part : parts) {
        const double w = part->diffuse + part->specular;
        if (w <= 0) continue;
        if (power == 0) {
            whole.s_low = part->s_low;
            whole.s_high = part->s_high;
        }
        whole.s_low = std::min(whole.s_low, part->s_low);
        whole.s_high = std::max(whole.s_high, part->s_high);
        whole.point += w * part->point;
        whole.normal += w * part->normal;
        whole.s_sigma += w * part->s_sigma;
        whole.diffuse += part->diffuse;
        whole.specular += part->specular;
        if (part->specular > 0) whole.gloss = std::min(whole.gloss, part->gloss);
        if (w > strongest) {
            strongest = w;
            whole.on_surface = part->on_surface;
            whole.to_light = part->to_light;
        }
        power += w;
    }
    if (power == 0) return whole;
    whole.point /= power;
    whole.normal /= power;
    whole.s_sigma /= power;
    for (const LitPatch* part : parts)
        if (part->diffuse + part->specular > 0)
            whole.radius_mm =
                std::max(whole.radius_mm, (part->point - whole.point).norm() + part->radius_mm);
    return whole;
}

/// Pieces so small that the beam spans about one: from the beam's median width along coarse rays.
int pieces_a_side(const Beam& beam, const SceneGeometry& geometry, double low, double high) {
    const double half_fan = beam.channel().sheet.fan_rad / 2;
    std::vector<double> widths;
    for (int i = 0; i < 16; ++i)
        for (int j = 0; j < 16; ++j) {
            const double s = low + (i + 0.5) / 16 * (high - low);
            const BeamRay ray = beam.ray(s, half_fan * ((j + 0.5) / 8 - 1));
            const SurfaceHit hit = geometry.first_hit(ray.origin, ray.direction);
            if (hit.object < 0) continue;
            if (const auto passing = beam.passing(hit, s)) widths.push_back(1 / passing->per_s);
        }
    int side = kFewest;
    if (widths.empty()) return side;
    const double width = median(std::move(widths));
    while (side < kMost && (high - low) / side > kBeamWidths * width) side *= 2;
    return side;
}

}  // namespace

LitPatches::LitPatches(const Beam& beam, const SceneGeometry& geometry, const SceneAxis& axis) {
    const double travel = axis.max - axis.min;
    const double low = axis.min - kBeyondTravel * travel, high = axis.max + kBeyondTravel * travel;
    side_ = pieces_a_side(beam, geometry, low, high);
    const auto n = static_cast<std::size_t>(side_);
    const double s_half = (high - low) / side_ / 2;
    const double half_fan = beam.channel().sheet.fan_rad / 2, phi_half = half_fan / side_;
    levels_.emplace_back(n * n);
    parallel_for_blocks(n, 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t j = 0; j < n; ++j)
                levels_[0][i * n + j] = single_piece(
                    beam, geometry,
                    {low + (2 * static_cast<double>(i) + 1) * s_half, s_half,
                     -half_fan + (2 * static_cast<double>(j) + 1) * phi_half, phi_half});
    });
    for (std::size_t side = n / 2; side >= 1; side /= 2) {
        const std::vector<LitPatch>& fine = levels_.back();
        std::vector<LitPatch> coarse(side * side);
        for (std::size_t i = 0; i < side; ++i)
            for (std::size_t j = 0; j < side; ++j) {
                const LitPatch* first = &fine[4 * i * side + 2 * j];
                coarse[i * side + j] =
                    joined({first, first + 1, first + 2 * side, first + 2 * side + 1});
            }
        levels_.push_back(std::move(coarse));
    }
}

}  // namespace stria
