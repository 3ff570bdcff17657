#include "host/fusion/background.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "host/core/errors.h"

namespace stria {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kRun = 16;  ///< cells

/// Direction of the line of sight of every cell, as a point of a screen.
class CellScreen {
  public:
    CellScreen(const RangeImage& image, const RangeSurface& surface)
        : surface_(surface), width_(image.width), height_(image.height) {
        Vector3d middle = Vector3d::Zero();
        for (const SurfaceVertex& v : surface.vertices) middle += v.position;
        middle /= static_cast<double>(surface.vertices.size());
        origin_ = surface.orthographic ? middle : surface.vertices.front().camera;
        const Vector3d forward = surface.orthographic ? Vector3d(-surface.towards_camera)
                                                      : (middle - origin_).normalized().eval();
        distance_ = surface.orthographic ? 0 : (middle - origin_).norm();
        axes_.row(2) = forward;
        axes_.row(0) = forward.unitOrthogonal();
        axes_.row(1) = forward.cross(axes_.row(0).transpose());
        const double worst = fit(1);
        if (worst > 0.2) fit(3);
    }

    /// Where the line of sight of a cell meets the screen, world.
    Vector3d at(int x, int y) const {
        const Vector2d q = map_.transpose() * terms(x, y, degree_);
        const double scale = surface_.orthographic ? 1 : distance_;
        return origin_ +
               scale * (axes_.row(0).transpose() * q.x() + axes_.row(1).transpose() * q.y()) +
               distance_ * axes_.row(2).transpose();
    }

  private:
    Eigen::VectorXd terms(int x, int y, int degree) const {
        const double a = 2.0 * x / width_ - 1, b = 2.0 * y / height_ - 1;
        Eigen::VectorXd row((degree + 1) * (degree + 2) / 2);
        int k = 0;
        for (int n = 0; n <= degree; ++n)
            for (int m = 0; m <= n; ++m) row[k++] = std::pow(a, n - m) * std::pow(b, m);
        return row;
    }

    Vector2d screen_point(const SurfaceVertex& vertex) const {
        const Vector3d q = axes_ * (vertex.position - origin_);
        return surface_.orthographic ? Vector2d(q.head<2>()) : Vector2d(q.head<2>() / q.z());
    }

    /// Fits the map; returns the rms in cells.
    double fit(int degree) {
        degree_ = degree;
        const std::size_t step = 1 + surface_.vertices.size() / 20000;
        const auto n = terms(0, 0, degree).size();
        Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n), right = Eigen::MatrixXd::Zero(n, 2);
        const auto each = [&](const auto& body) {
            for (std::size_t i = 0; i < surface_.vertices.size(); i += step) {
                const int cell = static_cast<int>(surface_.cells[i]);
                body(terms(cell % width_, cell / width_, degree),
                     screen_point(surface_.vertices[i]));
            }
        };
        each([&](const Eigen::VectorXd& row, const Vector2d& q) {
            normal += row * row.transpose();
            right += row * q.transpose();
        });
        normal.diagonal() *= 1 + 1e-12;  // a single row or column of points leaves it singular
        map_ = normal.ldlt().solve(right);
        double sum = 0, count = 0;
        each([&](const Eigen::VectorXd& row, const Vector2d& q) {
            sum += (map_.transpose() * row - q).squaredNorm();
            ++count;
        });
        const Vector2d cell = map_.transpose() * (terms(1, 1, degree) - terms(0, 0, degree));
        return std::sqrt(sum / count) / std::max(1e-12, cell.norm() / std::sqrt(2.0));
    }

    const RangeSurface& surface_;
    int width_, height_, degree_ = 1;
    Vector3d origin_;
    double distance_ = 0;
    Eigen::Matrix3d axes_;
    Eigen::MatrixXd map_;
};

}  // namespace

std::vector<std::array<Vector3d, 4>> background_quads(const RangeImage& image,
                                                      const RangeSurface& surface) {
    if (surface.camera_moves)
        throw Error(
            "fuse: carve_background needs scans whose camera stands still: a cell without return "
            "of a rail or turntable has no line of sight");
    std::vector<std::array<Vector3d, 4>> quads;
    if (surface.vertices.empty()) return quads;
    const CellScreen screen(image, surface);
    const auto is_open = [&](int x, int y) {
        return !image.has(x, y) && !image.has(x + 1, y) && !image.has(x, y + 1) &&
               !image.has(x + 1, y + 1);
    };
    for (int y = 0; y + 1 < image.height; ++y)
        for (int x = 0; x + 1 < image.width;) {
            int end = x;
            while (end + 1 < image.width && end - x < kRun && is_open(end, y)) ++end;
            if (end > x)
                quads.push_back({screen.at(x, y), screen.at(end, y), screen.at(end, y + 1),
                                 screen.at(x, y + 1)});
            x = std::max(x + 1, end);
        }
    return quads;
}

}  // namespace stria
