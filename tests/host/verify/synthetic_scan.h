#pragma once
#include <Eigen/Geometry>
#include <random>
#include <vector>

#include "host/verify/scan_points.h"

/// Scans made of points whose places and errors are known, as one camera at the origin sees them.
namespace stria::test_support {

class SyntheticScan {
  public:
    explicit SyntheticScan(unsigned seed) : rng(seed) {}

    ScanPoints scan;
    std::mt19937 rng;

    double normal() { return gauss_(rng); }
    double uniform(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(rng);
    }

    /// A point with an error along the way from the camera of `sigma_mm` normal to the surface.
    void add(const Eigen::Vector3d& place, const Eigen::Vector3d& surface_normal, double sigma_mm) {
        const Eigen::Vector3d away = place.normalized();
        const double along = sigma_mm / std::max(0.05, std::abs(away.dot(surface_normal)));
        add_at(place + along * normal() * away, along);
    }
    /// A point just there, stating that sigma.
    void add_at(const Eigen::Vector3d& place, double stated_sigma_mm) {
        const Eigen::Vector3f away = place.normalized().cast<float>();
        scan.positions.push_back(place);
        scan.towards_camera.push_back(-away);
        scan.noise.push_back({away, static_cast<float>(stated_sigma_mm), 0, 0});
    }

    /// `count` points evenly over the part of a sphere that is seen at most so flat.
    void add_sphere(const Eigen::Vector3d& centre, double radius_mm, int count, double sigma_mm,
                    double max_incidence_rad = 1.4) {
        for (int i = 0; i < count;) {
            const Eigen::Vector3d n = Eigen::Vector3d(normal(), normal(), normal()).normalized();
            const Eigen::Vector3d place = centre + radius_mm * n;
            if (-n.dot(place.normalized()) < std::cos(max_incidence_rad)) continue;
            add(place, n, sigma_mm);
            ++i;
        }
    }

    /// `count` points evenly over the rectangle centre + a edge_a + b edge_b, |a|, |b| <= 1/2.
    void add_rectangle(const Eigen::Vector3d& centre, const Eigen::Vector3d& edge_a,
                       const Eigen::Vector3d& edge_b, int count, double sigma_mm) {
        const Eigen::Vector3d n = edge_a.cross(edge_b).normalized();
        for (int i = 0; i < count; ++i)
            add(centre + uniform(-0.5, 0.5) * edge_a + uniform(-0.5, 0.5) * edge_b, n, sigma_mm);
    }

    /// The side of an upright rod (along y) that is seen.
    void add_rod(const Eigen::Vector3d& middle, double radius_mm, double length_mm, int count,
                 double sigma_mm) {
        for (int i = 0; i < count;) {
            const double turn = uniform(-M_PI, M_PI);
            const Eigen::Vector3d n(std::cos(turn), 0, std::sin(turn));
            const Eigen::Vector3d place =
                middle + radius_mm * n + Eigen::Vector3d(0, uniform(-0.5, 0.5) * length_mm, 0);
            if (-n.dot(place.normalized()) < 0.2) continue;
            add(place, n, sigma_mm);
            ++i;
        }
    }

  private:
    std::normal_distribution<double> gauss_{0.0, 1.0};
};

}  // namespace stria::test_support
