#pragma once
#include <Eigen/Core>
#include <vector>

#include "host/core/image.h"
#include "host/core/tri_mesh.h"

namespace stria {

/// Parallel view of a mesh, fitted into the picture.
struct MeshPictureOptions {
    Eigen::Vector3d towards_eye = {0.45, -0.8, 0.4};  ///< mesh frame, any length
    Eigen::Vector3d up = Eigen::Vector3d::UnitZ();    ///< not along towards_eye
    int width = 640;
    int height = 480;
    Eigen::Vector3f background = {1, 1, 1};  ///< R G B, 0..1
};

/// Picture of the mesh by a z-buffer with 2 x 2 supersampling, lit by a headlight: both sides
/// alike, back faces darker. Colours: one a vertex, or empty for a neutral grey. An empty mesh
/// gives the background.
ColourImage picture_of_mesh(const TriMesh& mesh, const std::vector<Eigen::Vector3f>& colours,
                            const MeshPictureOptions& options = {});

}  // namespace stria
