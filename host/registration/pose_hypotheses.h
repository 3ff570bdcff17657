#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "host/core/rigid3.h"
#include "host/registration/scan_surface.h"

namespace stria {

/// A thinned surface, its features (as shape_features gives them) and the points to compare.
struct ShapeKeys {
    const ScanSurface& surface;
    const Eigen::MatrixXf& features;
    const std::vector<std::uint32_t>& points;
};

/// A pose and how many correspondences of local shape agree with it.
struct PoseHypothesis {
    Rigid3 target_from_source;
    int support = 0;
};

/// Likely poses of one thinned surface on another, most supported first, no two alike: points of
/// like shape correspond; correspondences whose mutual distance and angles of normals are the same
/// on both sides are compatible; those that share many compatible others stand together for a pose.
/// Source: Chen, Sun, Yang, Tao, "SC2-PCR: A second order spatial compatibility for efficient and
/// robust point cloud registration", CVPR 2022; normals added here.
/// @param detail_mm  spacing of the points, which sets how exact distances are
std::vector<PoseHypothesis> pose_hypotheses(const ShapeKeys& source, const ShapeKeys& target,
                                            double detail_mm, int max_count);

}  // namespace stria
