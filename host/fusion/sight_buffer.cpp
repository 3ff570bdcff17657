#include "host/fusion/sight_buffer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace stria {
namespace {

using Eigen::Vector3d;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr int kMaxSide = 4096;       ///< px
constexpr double kMinForward = 0.3;  ///< of a ray: 72 deg off the axis

Eigen::Matrix3d axes_along(const Vector3d& forward) {
    Eigen::Matrix3d axes;
    const Vector3d right = forward.unitOrthogonal();
    axes << right.transpose(), forward.cross(right).transpose(), forward.transpose();
    return axes;
}

const Vector3d& eye(const SurfaceVertex& vertex, bool laser) {
    return laser ? vertex.laser : vertex.camera;
}

}  // namespace

using Quads = std::vector<std::array<Vector3d, 4>>;

SightBuffer::SightBuffer(const RangeSurface& surface, const std::vector<std::uint32_t>& triangles,
                         bool laser, double ramp_mm, double pixel_mm, const Quads& open)
    : orthographic_(surface.orthographic) {
    set_view(surface, triangles, laser, pixel_mm, open);
    if (width_ == 0) return;
    free_mm_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_),
                    kInfinity);
    draw_surface(surface, triangles, ramp_mm);
    close_undrawn(open);
    build_levels();
}

void SightBuffer::set_view(const RangeSurface& surface, const std::vector<std::uint32_t>& triangles,
                           bool laser, double pixel_mm, const Quads& open) {
    Vector3d middle = Vector3d::Zero(), mean_eye = Vector3d::Zero();
    double count = 0;
    for (const std::uint32_t t : triangles)
        for (const std::uint32_t v : surface.triangles[t]) {
            middle += surface.vertices[v].position;
            mean_eye += eye(surface.vertices[v], laser);
            ++count;
        }
    if (count == 0) return;
    middle /= count;
    origin_ = orthographic_ ? middle : Vector3d(mean_eye / count);
    axes_ = axes_along(orthographic_ ? Vector3d(-surface.towards_camera)
                                     : (middle - origin_).normalized().eval());
    Eigen::Array2d low = Eigen::Array2d::Constant(1e300), high = -low;
    double nearest = 1e300;
    const auto include = [&](const Vector3d& point) {
        const Vector3d q = axes_ * (point - origin_);
        if (!orthographic_ && q.z() < kMinForward * q.norm()) return;
        const Eigen::Array2d at = q.head<2>().array() / (orthographic_ ? 1.0 : q.z());
        low = low.min(at);
        high = high.max(at);
        nearest = std::min(nearest, q.z());
    };
    for (const std::uint32_t t : triangles)
        for (const std::uint32_t v : surface.triangles[t]) include(surface.vertices[v].position);
    for (const auto& quad : open)
        for (const Vector3d& corner : quad) include(corner);
    if (!(low < high).all()) return;
    scale_ = (orthographic_ ? 1 : nearest) / pixel_mm;
    scale_ = std::min(scale_, (kMaxSide - 8) / (high - low).maxCoeff());
    width_ = static_cast<int>(std::ceil((high.x() - low.x()) * scale_)) + 5;
    height_ = static_cast<int>(std::ceil((high.y() - low.y()) * scale_)) + 5;
    u0_ = 2 - low.x() * scale_;
    v0_ = 2 - low.y() * scale_;
}

bool SightBuffer::project(const Vector3d& point, Pixel& pixel) const {
    const Vector3d q = axes_ * (point - origin_);
    if (orthographic_) {
        pixel = {scale_ * q.x() + u0_, scale_ * q.y() + v0_, q.z()};
        return true;
    }
    const double range = q.norm();
    if (!(q.z() > kMinForward * range)) return false;
    pixel = {scale_ * q.x() / q.z() + u0_, scale_ * q.y() / q.z() + v0_, range};
    return true;
}

template <typename Paint>
void SightBuffer::draw(const std::array<Vector3d, 3>& corners, const Paint& paint) const {
    Pixel p[3];
    for (std::size_t k = 0; k < 3; ++k)
        if (!project(corners[k], p[k])) return;
    const double area =
        (p[1].u - p[0].u) * (p[2].v - p[0].v) - (p[2].u - p[0].u) * (p[1].v - p[0].v);
    if (area == 0) return;
    const auto first = [](double a, double b, double c) {
        return std::max(0, static_cast<int>(std::ceil(std::min({a, b, c}))));
    };
    const auto last = [](double a, double b, double c, int size) {
        return static_cast<int>(std::min(size - 1.0, std::floor(std::max({a, b, c}))));
    };
    for (int y = first(p[0].v, p[1].v, p[2].v); y <= last(p[0].v, p[1].v, p[2].v, height_); ++y)
        for (int x = first(p[0].u, p[1].u, p[2].u); x <= last(p[0].u, p[1].u, p[2].u, width_);
             ++x) {
            double share[3];
            for (int k = 0; k < 3; ++k) {
                const Pixel &a = p[(k + 1) % 3], &b = p[(k + 2) % 3];
                share[k] = ((a.u - x) * (b.v - y) - (b.u - x) * (a.v - y)) / area;
            }
            constexpr double kSlack = -1e-9;  // a pixel on an edge belongs to both sides
            if (share[0] < kSlack || share[1] < kSlack || share[2] < kSlack) continue;
            paint(static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                      static_cast<std::size_t>(x),
                  share[0] * p[0].range + share[1] * p[1].range + share[2] * p[2].range);
        }
}

void SightBuffer::draw_surface(const RangeSurface& surface,
                               const std::vector<std::uint32_t>& triangles, double ramp_mm) {
    for (const std::uint32_t t : triangles) {
        std::array<Vector3d, 3> corners;
        float sigma = 0;
        bool blocks = false;
        for (std::size_t k = 0; k < 3; ++k) {
            const SurfaceVertex& vertex = surface.vertices[surface.triangles[t][k]];
            corners[k] = vertex.position;
            sigma = std::max(sigma, vertex.sigma_mm);
            blocks |= !vertex.carves;
        }
        const double shorter_mm = 3 * static_cast<double>(sigma) + ramp_mm;
        double nearest = 1e300;
        for (const Vector3d& corner : corners) {
            Pixel pixel;
            if (project(corner, pixel)) nearest = std::min(nearest, pixel.range);
        }
        const bool is_gap = t >= surface.first_gap;
        draw(corners, [&](std::size_t pixel, double range) {
            const double end = is_gap ? nearest : range;
            const float sight = blocks ? -kInfinity : static_cast<float>(end - shorter_mm);
            free_mm_[pixel] = std::min(free_mm_[pixel], sight);
        });
    }
}

void SightBuffer::close_undrawn(const Quads& open) {
    std::vector<std::uint8_t> stays_open(open.empty() ? 0 : free_mm_.size(), 0);
    for (const auto& quad : open) {
        const auto paint = [&](std::size_t pixel, double) { stays_open[pixel] = 1; };
        draw({quad[0], quad[1], quad[2]}, paint);
        draw({quad[0], quad[2], quad[3]}, paint);
    }
    for (std::size_t i = 0; i < free_mm_.size(); ++i)
        if (free_mm_[i] == kInfinity && (open.empty() || !stays_open[i])) free_mm_[i] = -kInfinity;
}

void SightBuffer::build_levels() {
    levels_.push_back({width_, height_, free_mm_, free_mm_});
    while (levels_.back().width > 1 || levels_.back().height > 1) add_level();
    free_mm_ = {};
}

void SightBuffer::add_level() {
    const Level& fine = levels_.back();
    Level coarse;
    coarse.width = (fine.width + 1) / 2;
    coarse.height = (fine.height + 1) / 2;
    for (int y = 0; y < coarse.height; ++y)
        for (int x = 0; x < coarse.width; ++x) {
            float low = kInfinity, high = -kInfinity;
            for (int part = 0; part < 4; ++part) {
                const int fx = std::min(2 * x + (part & 1), fine.width - 1);
                const int fy = std::min(2 * y + (part >> 1), fine.height - 1);
                const auto i = static_cast<std::size_t>(fy * fine.width + fx);
                low = std::min(low, fine.low[i]);
                high = std::max(high, fine.high[i]);
            }
            coarse.low.push_back(low);
            coarse.high.push_back(high);
        }
    levels_.push_back(std::move(coarse));
}

SightBuffer::Answer SightBuffer::sees_box(const Vector3d& low, const Vector3d& high) const {
    if (levels_.empty()) return Answer::none;
    double u0 = 1e300, u1 = -1e300, v0 = 1e300, v1 = -1e300, far = -1e300, near = 1e300;
    bool cut = false;
    for (int c = 0; c < 8; ++c) {
        const Vector3d corner(c & 1 ? high.x() : low.x(), c & 2 ? high.y() : low.y(),
                              c & 4 ? high.z() : low.z());
        Pixel p;
        if (!project(corner, p)) {
            cut = true;
            continue;
        }
        u0 = std::min(u0, p.u);
        u1 = std::max(u1, p.u);
        v0 = std::min(v0, p.v);
        v1 = std::max(v1, p.v);
        far = std::max(far, p.range);
        near = std::min(near, p.range);
    }
    if (cut) return u0 > u1 ? Answer::none : Answer::some;
    if (!orthographic_)  // a face may come nearer than the corners
        near = (0.5 * (low + high) - origin_).norm() - 0.5 * (high - low).norm();
    u0 += 0.5, u1 += 0.5, v0 += 0.5, v1 += 0.5;  // a pixel's centre is at whole numbers
    if (u1 < 0 || v1 < 0 || u0 >= width_ || v0 >= height_) return Answer::none;
    const bool leaves = u0 < 0 || v0 < 0 || u1 >= width_ || v1 >= height_;
    int x0 = std::max(0, static_cast<int>(std::floor(u0)));
    int y0 = std::max(0, static_cast<int>(std::floor(v0)));
    int x1 = static_cast<int>(std::min(width_ - 1.0, std::floor(u1)));
    int y1 = static_cast<int>(std::min(height_ - 1.0, std::floor(v1)));
    std::size_t level = 0;
    while (x1 - x0 > 2 || y1 - y0 > 2) {
        x0 >>= 1, x1 >>= 1, y0 >>= 1, y1 >>= 1;
        ++level;
    }
    const Level& at = levels_[level];
    float least = kInfinity, most = -kInfinity;
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
            const auto i = static_cast<std::size_t>(y * at.width + x);
            least = std::min(least, at.low[i]);
            most = std::max(most, at.high[i]);
        }
    if (static_cast<double>(most) <= near) return Answer::none;
    return !leaves && static_cast<double>(least) > far ? Answer::all : Answer::some;
}

void SightBuffer::sees_voxels(const Vector3d& first, double voxel_mm, std::uint64_t bits[8]) const {
    const Level& at = levels_.front();
    for (int z = 0; z < 8; ++z)
        for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 8; ++x) {
                Pixel p;
                if (!project(first + voxel_mm * Vector3d(x, y, z), p)) continue;
                const double u = p.u + 0.5, v = p.v + 0.5;
                if (!(u >= 0 && v >= 0 && u < at.width && v < at.height)) continue;
                const auto i =
                    static_cast<std::size_t>(static_cast<int>(v) * at.width + static_cast<int>(u));
                if (p.range < static_cast<double>(at.low[i]))
                    bits[z] |= std::uint64_t{1} << (x + 8 * y);
            }
}

}  // namespace stria
