#include "host/fusion/facet.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <string>

#include "host/core/errors.h"
#include "host/fusion/volume.h"
#include "host/geometry/parallel.h"

namespace stria {
namespace {

using Eigen::Vector3d;

SightPlane sight_plane(const Vector3d& low, const Vector3d& high, const Vector3d& view,
                       bool forwards) {
    const Vector3d kOddDirection(1.0, 0.7548776662466927, 0.5698402909980532);
    SightPlane plane;
    plane.normal = view.cross(high - low);
    plane.offset = plane.normal.dot(low);
    plane.forwards = forwards;
    plane.tie_positive = plane.normal.dot(kOddDirection) > 0;
    return plane;
}

VoxelBox reach_of(const Facet& facet, const SurfaceVertex* const corner[3],
                  const RangeSurface& surface, double voxel_mm) {
    Vector3d low = Vector3d::Constant(1e300), high = Vector3d::Constant(-1e300);
    for (int k = 0; k < 3; ++k) {
        const Vector3d& position = corner[k]->position;
        const Vector3d view = surface.orthographic
                                  ? surface.towards_camera
                                  : (corner[k]->camera - position).normalized().eval();
        const double stretch = std::min(kGrazingFactor, 1 / std::max(0.01, view.dot(facet.normal)));
        for (const double along : {facet.front_mm * stretch, -facet.tail_mm * stretch}) {
            const Vector3d end = position + along * view;
            low = low.cwiseMin(end);
            high = high.cwiseMax(end);
        }
    }
    const double limit = 8.0 * SdfVolume::kMaxCoordinate * voxel_mm;
    if (!(low.minCoeff() > -limit && high.maxCoeff() < limit))
        throw Error("fuse: a scan point lies farther than " + std::to_string(limit) +
                    " mm from the origin, which a voxel of " + std::to_string(voxel_mm) +
                    " mm cannot address; use a larger voxel, or move the scans nearer");
    return {(low / voxel_mm).array().floor().cast<int>().matrix(),
            (high / voxel_mm).array().ceil().cast<int>().matrix()};
}

Facet make_facet(const RangeSurface& surface, std::size_t index, const RampLengths& ramp,
                 double voxel_mm) {
    const auto& triangle = surface.triangles[index];
    const SurfaceVertex* corner[3];
    for (std::size_t k = 0; k < 3; ++k) corner[k] = &surface.vertices[triangle[k]];
    Facet facet;
    facet.normal = (corner[1]->position - corner[0]->position)
                       .cross(corner[2]->position - corner[0]->position)
                       .normalized();
    facet.height = facet.normal.dot(corner[0]->position);
    facet.station = (corner[0]->camera + corner[1]->camera + corner[2]->camera) / 3;
    const double three_sigma =
        3 * static_cast<double>(
                std::max({corner[0]->sigma_mm, corner[1]->sigma_mm, corner[2]->sigma_mm}));
    facet.front_mm = ramp.front_mm + three_sigma;
    facet.tail_mm = std::max(ramp.tail_mm, ramp.tail_mm / 2 + three_sigma);
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        const bool forwards = triangle[k] < triangle[next];
        const SurfaceVertex& low = *corner[forwards ? k : next];
        const SurfaceVertex& high = *corner[forwards ? next : k];
        const Vector3d view =
            surface.orthographic
                ? surface.towards_camera
                : (0.5 * (low.camera + high.camera) - low.position).normalized().eval();
        facet.plane[k] = sight_plane(low.position, high.position, view, forwards);
    }
    facet.reach = reach_of(facet, corner, surface, voxel_mm);
    return facet;
}

}  // namespace

bool Facet::may_touch(const Vector3d& centre, double half_side) const {
    const double spread = half_side * normal.cwiseAbs().sum();
    const double above = normal.dot(centre) - height;
    if (above - spread > front_mm || above + spread < -tail_mm) return false;
    for (const SightPlane& side : plane) {
        const double sign = side.forwards ? 1 : -1;
        const double best = sign * (side.normal.dot(centre) - side.offset) +
                            half_side * side.normal.cwiseAbs().sum();
        if (best < -1e-9) return false;
    }
    return true;
}

std::vector<Facet> make_facets(const RangeSurface& surface, const RampLengths& ramp,
                               double voxel_mm) {
    std::vector<Facet> facets(surface.triangles.size());
    parallel_for_blocks(facets.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            facets[i] = make_facet(surface, i, ramp, voxel_mm);
    });
    return facets;
}

}  // namespace stria
