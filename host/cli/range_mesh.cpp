#include "host/cli/range_mesh.h"

#include <algorithm>

#include "host/geometry/range_grid.h"

namespace stria {

PointCloud range_points(const RangeImage& image) {
    PointCloud cloud;
    VertexAttribute normal{"normal", 3, {}}, intensity{"intensity", 1, {}}, sigma{"sigma", 1, {}},
        across{"sigma_across", 1, {}}, systematic{"sigma_systematic", 1, {}};
    for (std::size_t cell = 0; cell < image.cell_count(); ++cell) {
        if (image.mask[cell] == 0) continue;
        const RangePoint& point = image.points[cell];
        cloud.positions.push_back(point.position);
        normal.values.insert(normal.values.end(), point.normal.begin(), point.normal.end());
        intensity.values.push_back(point.intensity);
        sigma.values.push_back(point.sigma_mm);
        across.values.push_back(point.sigma_across_mm);
        systematic.values.push_back(point.sigma_systematic_mm);
    }
    for (VertexAttribute* attribute : {&normal, &intensity, &sigma, &across, &systematic}) {
        const bool known = std::any_of(attribute->values.begin(), attribute->values.end(),
                                       [](float value) { return value != 0.0F; });
        if (known) cloud.attributes.push_back(std::move(*attribute));
    }
    return cloud;
}

TriMesh range_mesh(const RangeImage& image) {
    PointCloud cloud = range_points(image);
    TriMesh mesh;
    mesh.positions = std::move(cloud.positions);
    mesh.attributes = std::move(cloud.attributes);
    std::vector<std::uint32_t> vertex_of(image.cell_count(), 0);
    std::uint32_t next = 0;
    for (std::size_t cell = 0; cell < image.cell_count(); ++cell)
        if (image.mask[cell] != 0) vertex_of[cell] = next++;
    for (const auto& cells : range_triangles(image))
        mesh.triangles.push_back({vertex_of[cells[0]], vertex_of[cells[1]], vertex_of[cells[2]]});
    return mesh;
}

}  // namespace stria
