#include "host/render/mesh_picture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace stria {
namespace {

constexpr int kSamples = 2;  // a pixel's side in samples

/// A vertex in the picture: x right, y down in samples, z towards the eye in mm.
struct ViewVertex {
    Eigen::Vector3d at;
    Eigen::Vector3f normal;
    Eigen::Vector3f colour;
};

Eigen::Matrix3d view_from_mesh(const MeshPictureOptions& options) {
    const Eigen::Vector3d eye = options.towards_eye.normalized();
    Eigen::Vector3d right = options.up.cross(eye);
    if (right.norm() < 1e-9) right = eye.unitOrthogonal();
    right.normalize();
    Eigen::Matrix3d view;
    view.row(0) = right;
    view.row(1) = -eye.cross(right);  // down
    view.row(2) = eye;
    return view;
}

std::vector<Eigen::Vector3d> vertex_normals(const TriMesh& mesh) {
    std::vector<Eigen::Vector3d> normals(mesh.positions.size(), Eigen::Vector3d::Zero());
    for (const auto& t : mesh.triangles) {
        const Eigen::Vector3d& a = mesh.positions[t[0]];
        const Eigen::Vector3d n = (mesh.positions[t[1]] - a).cross(mesh.positions[t[2]] - a);
        for (const std::uint32_t v : t) normals[v] += n;
    }
    return normals;
}

std::vector<ViewVertex> to_view(const TriMesh& mesh, const std::vector<Eigen::Vector3f>& colours,
                                const MeshPictureOptions& options) {
    const Eigen::Matrix3d view = view_from_mesh(options);
    const std::vector<Eigen::Vector3d> normals = vertex_normals(mesh);
    std::vector<ViewVertex> out(mesh.positions.size());
    Eigen::Vector2d low(1e300, 1e300), high(-1e300, -1e300);
    for (std::size_t i = 0; i < out.size(); ++i) {
        out[i].at = view * mesh.positions[i];
        out[i].normal = (view * normals[i]).normalized().cast<float>();
        out[i].colour = colours.empty() ? Eigen::Vector3f(0.72f, 0.74f, 0.78f) : colours[i];
        low = low.cwiseMin(out[i].at.head<2>());
        high = high.cwiseMax(out[i].at.head<2>());
    }
    const Eigen::Vector2d size(options.width * kSamples, options.height * kSamples);
    const Eigen::Vector2d extent = (high - low).cwiseMax(1e-9);
    const double scale = 0.94 * std::min(size.x() / extent.x(), size.y() / extent.y());
    for (ViewVertex& v : out)
        v.at.head<2>() = (v.at.head<2>() - 0.5 * (low + high)) * scale + 0.5 * size;
    return out;
}

struct Canvas {
    int width, height;
    std::vector<float> depth;
    std::vector<Eigen::Vector3f> colour;
};

Eigen::Vector3f lit(const Eigen::Vector3f& colour, const Eigen::Vector3f& normal, bool back) {
    const float length = normal.norm();
    const float cosine = length > 1e-6f ? std::abs(normal.z()) / length : 1.0f;
    return colour * (0.25f + 0.75f * cosine) * (back ? 0.6f : 1.0f);
}

void draw_triangle(const ViewVertex& a, const ViewVertex& b, const ViewVertex& c, Canvas& canvas) {
    const Eigen::Vector2d ab = (b.at - a.at).head<2>(), ac = (c.at - a.at).head<2>();
    const double area = ab.x() * ac.y() - ab.y() * ac.x();
    if (std::abs(area) < 1e-12) return;
    const bool back = area > 0;  // y is down: counter-clockwise in the mesh has a negative area
    const auto clip = [](double v, int most) {
        return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(most)));
    };
    const int left = clip(std::ceil(std::min({a.at.x(), b.at.x(), c.at.x()}) - 0.5), canvas.width);
    const int right =
        clip(std::floor(std::max({a.at.x(), b.at.x(), c.at.x()}) + 0.5), canvas.width);
    const int top = clip(std::ceil(std::min({a.at.y(), b.at.y(), c.at.y()}) - 0.5), canvas.height);
    const int bottom =
        clip(std::floor(std::max({a.at.y(), b.at.y(), c.at.y()}) + 0.5), canvas.height);
    for (int y = top; y < bottom; ++y) {
        for (int x = left; x < right; ++x) {
            const Eigen::Vector2d p = Eigen::Vector2d(x + 0.5, y + 0.5) - a.at.head<2>();
            const double wb = (p.x() * ac.y() - p.y() * ac.x()) / area;
            const double wc = (ab.x() * p.y() - ab.y() * p.x()) / area;
            const double wa = 1.0 - wb - wc;
            if (wa < -1e-9 || wb < -1e-9 || wc < -1e-9) continue;
            const auto z = static_cast<float>(wa * a.at.z() + wb * b.at.z() + wc * c.at.z());
            const std::size_t i =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(canvas.width) +
                static_cast<std::size_t>(x);
            if (z <= canvas.depth[i]) continue;
            canvas.depth[i] = z;
            const auto fa = static_cast<float>(wa), fb = static_cast<float>(wb);
            const auto fc = static_cast<float>(wc);
            canvas.colour[i] = lit(fa * a.colour + fb * b.colour + fc * c.colour,
                                   fa * a.normal + fb * b.normal + fc * c.normal, back);
        }
    }
}

}  // namespace

ColourImage picture_of_mesh(const TriMesh& mesh, const std::vector<Eigen::Vector3f>& colours,
                            const MeshPictureOptions& options) {
    if (!colours.empty() && colours.size() != mesh.positions.size())
        throw std::invalid_argument("picture_of_mesh: " + std::to_string(colours.size()) +
                                    " colours for " + std::to_string(mesh.positions.size()) +
                                    " vertices");
    if (options.width < 1 || options.height < 1 || options.width > 8192 || options.height > 8192)
        throw std::invalid_argument("picture_of_mesh: size " + std::to_string(options.width) +
                                    " x " + std::to_string(options.height) +
                                    ": expected 1 to 8192");
    Canvas canvas{options.width * kSamples, options.height * kSamples, {}, {}};
    const auto samples =
        static_cast<std::size_t>(canvas.width) * static_cast<std::size_t>(canvas.height);
    canvas.depth.assign(samples, -std::numeric_limits<float>::max());
    canvas.colour.assign(samples, options.background);
    const std::vector<ViewVertex> vertices = to_view(mesh, colours, options);
    for (const auto& t : mesh.triangles)
        draw_triangle(vertices[t[0]], vertices[t[1]], vertices[t[2]], canvas);

    ColourImage picture(options.width, options.height, 3);
    for (int y = 0; y < options.height; ++y) {
        for (int x = 0; x < options.width; ++x) {
            Eigen::Vector3f sum = Eigen::Vector3f::Zero();
            for (int dy = 0; dy < kSamples; ++dy)
                for (int dx = 0; dx < kSamples; ++dx)
                    sum += canvas.colour[static_cast<std::size_t>(y * kSamples + dy) *
                                             static_cast<std::size_t>(canvas.width) +
                                         static_cast<std::size_t>(x * kSamples + dx)];
            sum /= static_cast<float>(kSamples * kSamples);
            for (int c = 0; c < 3; ++c)
                picture.at(x, y, c) =
                    static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(sum[c], 0.0f, 1.0f)));
        }
    }
    return picture;
}

}  // namespace stria
