#include "host/registration/line_of_sight.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace stria {
namespace {

using Eigen::Vector3d;
constexpr int kMaxSide = 2000;  ///< cells
/// An eye may move by this many cells: a mirror's image of the laser does, by little.
constexpr double kMaxTravel = 10;

}  // namespace

LineOfSight::LineOfSight(const ScanSurface& surface, double cell_mm, From from) {
    if (surface.points.empty() || !(cell_mm > 0)) return;
    perspective_ = !surface.stations.empty();
    whole_ = surface.is_whole;
    Vector3d into = -Vector3d::UnitZ();
    if (perspective_) {
        const auto eye_of = [&](const Station& station) {
            return from == From::camera ? station.camera_in_scan : station.laser_in_scan;
        };
        eye_ = eye_of(surface.stations.front());
        for (const Station& station : surface.stations)
            if ((eye_of(station) - eye_).norm() > kMaxTravel * cell_mm) return;  // it moved
        into = (surface.centre - eye_).normalized();
    }
    axes_.row(2) = into.transpose();
    axes_.row(0) = into.unitOrthogonal().transpose();
    axes_.row(1) = into.cross(axes_.row(0).transpose()).transpose();
    const double distance = perspective_ ? (surface.centre - eye_).norm() : 1.0;
    cell_ = cell_mm / distance;

    Eigen::Vector2d high = Eigen::Vector2d::Constant(-1e300);
    low_ = -high;
    const auto flat = [&](const Vector3d& point, double& depth) -> Eigen::Vector2d {
        const Vector3d p = axes_ * (point - eye_);
        depth = p.z();
        return perspective_ ? Eigen::Vector2d(p.head<2>() / p.z()) : Eigen::Vector2d(p.head<2>());
    };
    double depth = 0;
    for (const Vector3d& point : surface.points) {
        const Eigen::Vector2d at = flat(point, depth);
        if (perspective_ && !(depth > 0)) return;  // sees more than half of space: no picture
        low_ = low_.cwiseMin(at);
        high = high.cwiseMax(at);
    }
    const Eigen::Vector2d size = (high - low_) / cell_;
    if (!(size.maxCoeff() < kMaxSide)) return;
    width_ = static_cast<int>(size.x()) + 1;
    height_ = static_cast<int>(size.y()) + 1;
    seen_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), {});
    for (const Vector3d& point : surface.points) {
        const Eigen::Vector2d at = (flat(point, depth) - low_) / cell_;
        const int x = std::min(width_ - 1, static_cast<int>(at.x()));
        const int y = std::min(height_ - 1, static_cast<int>(at.y()));
        Seen& seen = seen_[static_cast<std::size_t>(y * width_ + x)];
        const auto d = static_cast<float>(depth);
        if (seen.least > seen.greatest) seen = {d, d};
        seen.least = std::min(seen.least, d);
        seen.greatest = std::max(seen.greatest, d);
    }
    usable_ = true;
}

bool LineOfSight::locate(const Vector3d& point, int& x, int& y, double& depth) const {
    const Vector3d p = axes_ * (point - eye_);
    depth = p.z();
    if (perspective_ && !(depth > 0)) return false;
    const Eigen::Vector2d flat = p.head<2>() / (perspective_ ? depth : 1.0);
    const Eigen::Vector2d at = (flat - low_) / cell_;
    if (!(at.minCoeff() >= 0 && at.x() < width_ && at.y() < height_)) return false;
    x = static_cast<int>(at.x());
    y = static_cast<int>(at.y());
    return true;
}

bool LineOfSight::is_seen_through(int x, int y, double depth) const {
    for (int v = y - 1; v <= y + 1; ++v)
        for (int u = x - 1; u <= x + 1; ++u) {
            if (u < 0 || v < 0 || u >= width_ || v >= height_) return false;
            const Seen& seen = seen_[static_cast<std::size_t>(v * width_ + u)];
            if (seen.least > seen.greatest || static_cast<double>(seen.least) < depth) return false;
        }
    return true;
}

LineOfSight::Verdict LineOfSight::at(const Vector3d& point_in_scan, double tolerance_mm) const {
    int x = 0, y = 0;
    double depth = 0;
    if (!usable_ || !locate(point_in_scan, x, y, depth)) return Verdict::unknown;
    const Seen& seen = seen_[static_cast<std::size_t>(y * width_ + x)];
    if (seen.least > seen.greatest) return Verdict::unknown;
    if (depth < static_cast<double>(seen.least) - tolerance_mm)
        return is_seen_through(x, y, depth + tolerance_mm) ? Verdict::in_front : Verdict::unknown;
    if (depth > static_cast<double>(seen.greatest) + tolerance_mm) return Verdict::behind;
    return Verdict::near;
}

bool LineOfSight::sees_nothing_at(const Vector3d& point_in_scan) const {
    int x = 0, y = 0;
    double depth = 0;
    if (!usable_) return false;
    if (!locate(point_in_scan, x, y, depth)) return whole_ && (!perspective_ || depth > 0);
    for (int v = std::max(0, y - 1); v <= std::min(height_ - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(width_ - 1, x + 1); ++u) {
            const Seen& seen = seen_[static_cast<std::size_t>(v * width_ + u)];
            if (seen.least <= seen.greatest) return false;
        }
    return true;
}

bool LineOfSight::may_be_hidden(const Vector3d& point_in_scan, double tolerance_mm) const {
    int x = 0, y = 0;
    double depth = 0;
    if (!usable_) return true;
    if (!locate(point_in_scan, x, y, depth)) return false;
    for (int v = std::max(0, y - 2); v <= std::min(height_ - 1, y + 2); ++v)
        for (int u = std::max(0, x - 2); u <= std::min(width_ - 1, x + 2); ++u) {
            const Seen& seen = seen_[static_cast<std::size_t>(v * width_ + u)];
            if (seen.least <= seen.greatest &&
                static_cast<double>(seen.least) < depth - tolerance_mm)
                return true;
        }
    return false;
}

Vector3d LineOfSight::towards_eye(const Vector3d& point_in_scan) const {
    return perspective_ ? Vector3d((eye_ - point_in_scan).normalized())
                        : Vector3d(-axes_.row(2).transpose());
}

}  // namespace stria
