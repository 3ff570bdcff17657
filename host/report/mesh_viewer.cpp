#include "host/report/mesh_viewer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "host/io/image_io.h"
#include "host/render/mesh_picture.h"
#include "host/report/base64.h"

namespace stria {
namespace {

constexpr int kWidth = 760, kHeight = 520;

template <typename T>
std::string data_script(const std::string& id, const std::vector<T>& values) {
    std::string bytes(values.size() * sizeof(T), '\0');
    if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
    return "<script type='text/plain' id='" + id + "'>" + to_base64(bytes) + "</script>\n";
}

std::string numbers(const float* values, int count) {
    std::string out;
    for (int i = 0; i < count; ++i) out += (i ? " " : "") + std::to_string(values[i]);
    return out;
}

/// Places as 16-bit shares of the box, and the box's size in view units: its diagonal is 2.
struct PackedPlaces {
    std::vector<std::uint16_t> values;  // four a vertex, the last unused
    Eigen::Vector3f size = Eigen::Vector3f::Ones();
};

PackedPlaces pack_places(const TriMesh& mesh) {
    PackedPlaces out;
    Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
    for (const Eigen::Vector3d& p : mesh.positions) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    const Eigen::Vector3d extent =
        mesh.positions.empty() ? Eigen::Vector3d::Ones() : (high - low).cwiseMax(1e-9).eval();
    for (const Eigen::Vector3d& p : mesh.positions) {
        const Eigen::Vector3d share = (p - low).cwiseQuotient(extent);
        for (int k = 0; k < 3; ++k)
            out.values.push_back(static_cast<std::uint16_t>(std::lround(65535.0 * share[k])));
        out.values.push_back(0);
    }
    out.size = (extent * (1.9 / extent.norm())).cast<float>();
    return out;
}

std::vector<std::uint8_t> pack_colours(const ReportMesh& mesh) {
    std::vector<std::uint8_t> out;
    for (std::size_t i = 0; i < mesh.mesh.positions.size(); ++i) {
        const Eigen::Vector3f colour =
            mesh.colours.empty() ? Eigen::Vector3f(0.72f, 0.74f, 0.78f) : mesh.colours[i];
        for (int k = 0; k < 3; ++k)
            out.push_back(
                static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(colour[k], 0.0f, 1.0f))));
        out.push_back(255);
    }
    return out;
}

/// Column-major rotation: x right, y up, z towards the eye.
Eigen::Matrix3f view_rotation(const Eigen::Vector3d& towards_eye, const Eigen::Vector3d& up) {
    const Eigen::Vector3d eye = towards_eye.normalized();
    Eigen::Vector3d right = up.cross(eye);
    right = right.norm() < 1e-9 ? eye.unitOrthogonal() : right.normalized();
    Eigen::Matrix3d view;
    view << right.transpose(), eye.cross(right).transpose(), eye.transpose();
    return view.cast<float>();
}

/// Zoom at which the first view fills the canvas.
double fitting_zoom(const TriMesh& mesh, const Eigen::Matrix3f& view) {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
    for (const Eigen::Vector3d& p : mesh.positions) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    if (mesh.positions.empty()) return 1;
    const double to_view = 1.9 / (high - low).cwiseMax(1e-9).norm();
    double right = 1e-9, up = 1e-9;
    for (const Eigen::Vector3d& p : mesh.positions) {
        const Eigen::Vector3d seen = view.cast<double>() * ((p - 0.5 * (low + high)) * to_view);
        right = std::max(right, std::abs(seen.x()));
        up = std::max(up, std::abs(seen.y()));
    }
    return 0.94 * std::min(static_cast<double>(kWidth) / kHeight / right, 1.0 / up);
}

}  // namespace

std::string mesh_viewer_html(const ReportMesh& mesh, const std::string& id) {
    if (!mesh.colours.empty() && mesh.colours.size() != mesh.mesh.positions.size())
        throw std::invalid_argument("report: " + std::to_string(mesh.colours.size()) +
                                    " colours for " + std::to_string(mesh.mesh.positions.size()) +
                                    " vertices of '" + mesh.caption + "'");
    MeshPictureOptions options;
    options.towards_eye = mesh.towards_eye;
    options.up = mesh.up;
    options.width = kWidth;
    options.height = kHeight;
    const ColourImage still = picture_of_mesh(mesh.mesh, mesh.colours, options);
    const PackedPlaces places = pack_places(mesh.mesh);
    const Eigen::Matrix3f view = view_rotation(mesh.towards_eye, mesh.up);
    std::vector<std::uint32_t> corners;
    for (const auto& t : mesh.mesh.triangles) corners.insert(corners.end(), t.begin(), t.end());

    std::string out = "<div class='viewer'><img alt='' width='" + std::to_string(kWidth) +
                      "' height='" + std::to_string(kHeight) + "' src='data:image/png;base64," +
                      to_base64(encode_png(still)) + "'>\n<canvas data-mesh='" + id +
                      "' data-turn='" + numbers(view.data(), 9) + "' data-size='" +
                      numbers(places.size.data(), 3) + "' data-zoom='" +
                      std::to_string(fitting_zoom(mesh.mesh, view)) + "'></canvas></div>\n";
    out += data_script(id + "-places", places.values);
    out += data_script(id + "-colours", pack_colours(mesh));
    out += data_script(id + "-corners", corners);
    return out;
}

}  // namespace stria
