#include "host/verify/probing.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "host/core/errors.h"
#include "host/core/short_number.h"
#include "host/geometry/fit.h"

namespace stria {
namespace {

using Eigen::Vector3d;

std::vector<double> distances_from(const SphereFit& fit, const std::vector<Vector3d>& points) {
    std::vector<double> residuals;
    for (const Vector3d& p : points) residuals.push_back((p - fit.centre).norm() - fit.radius_mm);
    return residuals;
}

SphereFit fit_of(const std::vector<Vector3d>& points, const std::vector<std::uint8_t>& kept,
                 const std::optional<double>& diameter_mm) {
    std::vector<Vector3d> used;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (kept[i] != 0) used.push_back(points[i]);
    const SphereFit fit =
        diameter_mm ? fit_sphere_of_radius(used, *diameter_mm / 2) : fit_sphere(used);
    if (!fit.converged) throw Error("the least-squares sphere was not found: too little of it");
    return fit;
}

/// Share of 1200 parts of equal area of the sphere that have points: bands of equal height, each in
/// equal parts.
double coverage_of(const std::vector<Vector3d>& directions) {
    constexpr int kBands = 24, kParts = 50;
    std::vector<std::uint8_t> hit(static_cast<std::size_t>(kBands) * kParts, 0);
    for (const Vector3d& d : directions) {
        const int band = std::clamp(static_cast<int>((d.z() + 1) / 2 * kBands), 0, kBands - 1);
        const double turn = (std::atan2(d.y(), d.x()) + M_PI) / (2 * M_PI);
        const int part = std::clamp(static_cast<int>(turn * kParts), 0, kParts - 1);
        hit[static_cast<std::size_t>(band * kParts + part)] = 1;
    }
    return static_cast<double>(std::count(hit.begin(), hit.end(), 1)) / (kBands * kParts);
}

void describe_cap(MeasuredSphere& sphere, const std::vector<Vector3d>& normals) {
    Vector3d sum = Vector3d::Zero();
    for (const Vector3d& n : normals) sum += n;
    sphere.coverage = coverage_of(normals);
    if (sum.norm() > 0) sphere.middle = sum.normalized();
    for (const Vector3d& n : normals)
        sphere.cap_rad =
            std::max(sphere.cap_rad, std::acos(std::clamp(n.dot(sphere.middle), -1.0, 1.0)));
}

/// Covariance of centre and radius: sigma^2 (J^T J)^-1, J rows (-n, -1); of the centre alone where
/// the radius is given.
void add_covariance(MeasuredSphere& sphere, const std::vector<Vector3d>& normals,
                    bool free_radius) {
    Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
    for (std::size_t i = 0; i < normals.size(); ++i) {
        if (sphere.form.kept[i] == 0) continue;
        Eigen::Vector4d row;
        row << normals[i], free_radius ? 1.0 : 0.0;
        information += row * row.transpose();
    }
    if (!free_radius) information(3, 3) = 1;
    const Eigen::Matrix4d covariance =
        std::pow(sphere.form.sigma_mm, 2) * information.ldlt().solve(Eigen::Matrix4d::Identity());
    sphere.centre_covariance = covariance.topLeftCorner<3, 3>();
    if (free_radius) sphere.diameter_sigma_mm = 2 * std::sqrt(covariance(3, 3));
}

}  // namespace

MeasuredSphere measure_sphere(const ScanPoints& scan, const SphereRegion& region,
                              std::optional<double> diameter_mm) {
    if (region.points.size() < 100)
        throw Error("the sphere shows in " + std::to_string(region.points.size()) +
                    " points that count (" + std::to_string(region.too_flat) +
                    " more are seen too flat, " + std::to_string(region.beside) +
                    " lie on or next to other things); expected at least 100");
    MeasuredSphere sphere;
    sphere.region = region;
    sphere.points = chosen(scan, region.points);
    const std::vector<Vector3d>& places = sphere.points.positions;
    const SphereFit first =
        fit_of(places, std::vector<std::uint8_t>(places.size(), 1), diameter_mm);
    std::vector<std::uint8_t> kept =
        keep_mask(distances_from(first, places), most_rejected(places.size()));
    const SphereFit fit = fit_of(places, kept, diameter_mm);
    sphere.centre = fit.centre;
    sphere.diameter_mm = 2 * fit.radius_mm;
    std::vector<Vector3d> normals;
    for (const Vector3d& p : places) normals.push_back((p - fit.centre).normalized());
    sphere.form = form_figures(distances_from(fit, places), std::move(kept), diameter_mm ? 3 : 4,
                               sphere.points, normals);
    describe_cap(sphere, normals);
    add_covariance(sphere, normals, !diameter_mm);
    return sphere;
}

void check_found(const FoundSphere& found, double calibrated_diameter_mm) {
    const double diameter = 2 * found.radius_mm;
    if (std::abs(diameter - calibrated_diameter_mm) > 0.05 * calibrated_diameter_mm)
        throw Error("found a sphere of diameter " + short_number(diameter) +
                    " mm, the artefact's is " + short_number(calibrated_diameter_mm) +
                    " mm: another artefact, or another unit?");
    if (found.sigma_mm > 0.01 * found.radius_mm)
        throw Error("the points scatter by " + short_number(found.sigma_mm) +
                    " mm (one standard deviation) about the sphere of diameter " +
                    short_number(diameter) + " mm: expected at most a hundredth of its radius");
}

ProbingPosition probe_sphere(const ScanPoints& scan, const Artefact& artefact,
                             const SphereRegionOptions& options, std::mt19937& rng) {
    const CalibratedLength diameter = at_temperature(artefact, artefact.diameters.at(0));
    SphereSearch search;
    search.least_diameter_mm = search.greatest_diameter_mm = diameter.mm;
    search.most = 2;
    const std::vector<FoundSphere> found = find_spheres(scan, search, rng);
    if (found.empty())
        throw Error("found no sphere of about " + short_number(diameter.mm) + " mm in " +
                    std::to_string(scan.positions.size()) + " points");
    check_found(found[0], diameter.mm);
    if (found.size() > 1 && std::abs(2 * found[1].radius_mm - diameter.mm) < 0.05 * diameter.mm)
        throw Error("found two spheres of about " + short_number(diameter.mm) +
                    " mm, expected one: cut the scan, or is it a ball bar?");
    ProbingPosition position;
    position.sphere = measure_sphere(scan, sphere_region(scan, found[0], options));
    position.size_mm = position.sphere.diameter_mm - diameter.mm;
    position.size_expanded_mm =
        combined({diameter.expanded_mm, 2 * position.sphere.diameter_sigma_mm});
    return position;
}

}  // namespace stria
