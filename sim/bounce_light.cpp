#include "sim/bounce_light.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sim/form_factor.h"

namespace stria {
namespace {

constexpr double kFarEnough = 0.2;        ///< radius over distance below which a patch is a point
constexpr double kStraightEnough = 0.98;  ///< length of the mean normal
constexpr double kGrazing = 1e-5;         ///< cosine; normals are known to 1e-7
constexpr double kLiftMm = 5e-3;          ///< off the lit surface, where a shadow ray ends
constexpr double kFirstBin = 0.75;        ///< beam widths from the passage to the first border
constexpr double kBinGrowth = 1.3;
constexpr double kBinBlur = 0.6;      ///< of a bin's width: neighbours then add up to 0.2 % ripple
constexpr double kLeastLight = 0.01;  ///< electrons in the scene's exposure that count

/// Borders in s, growing from the passage outward; what falls between two becomes one Gaussian.
class SweepBins {
  public:
    SweepBins(double passage, double width, double low, double high) : middle_(passage) {
        double reach = kFirstBin * width;
        const double farthest = std::max(high - passage, passage - low);
        while (count_ < kMost - 1 && reach < farthest) {
            border_[static_cast<std::size_t>(count_++)] = reach;
            reach *= kBinGrowth;
        }
        border_[static_cast<std::size_t>(count_++)] = std::max(reach, farthest);
    }

    /// Spreads `amount` evenly over low..high.
    void add(double low, double high, double sigma, double amount) {
        low -= middle_;
        high -= middle_;
        if (low < 0) add_side(0, std::max(0.0, -high), -low, high - low, sigma, amount);
        if (high > 0) add_side(1, std::max(0.0, low), high, high - low, sigma, amount);
    }

    template <typename Use>
    void for_each(Use use) const {
        for (int side = 0; side < 2; ++side)
            for (int i = 0; i < count_; ++i) {
                const Bin& bin = bins_[static_cast<std::size_t>(side * kMost + i)];
                if (bin.amount <= 0) continue;
                const double centre = bin.first_moment / bin.amount;
                const double sigma = bin.sigma_sum / bin.amount;
                const double blur = kBinBlur * (border_[static_cast<std::size_t>(i)] - lower(i));
                use(middle_ + (side == 0 ? -centre : centre), std::hypot(sigma, blur), bin.amount);
            }
    }

  private:
    static constexpr int kMost = 48;
    struct Bin {
        double amount = 0, first_moment = 0, sigma_sum = 0;
    };
    double lower(int i) const { return i == 0 ? 0 : border_[static_cast<std::size_t>(i - 1)]; }

    void add_side(int side, double from, double to, double length, double sigma, double amount) {
        const auto end = border_.begin() + count_;
        auto i = static_cast<int>(std::upper_bound(border_.begin(), end, from) - border_.begin());
        for (i = std::min(i, count_ - 1); i < count_; ++i) {
            const double a = std::max(from, lower(i));
            const double b =
                i == count_ - 1 ? to : std::min(to, border_[static_cast<std::size_t>(i)]);
            if (b <= a) break;
            const double part = amount * (b - a) / length;
            Bin& bin = bins_[static_cast<std::size_t>(side * kMost + i)];
            bin.amount += part;
            bin.first_moment += part * (a + b) / 2;
            bin.sigma_sum += part * sigma;
        }
    }

    double middle_;
    std::array<double, kMost> border_{};
    int count_ = 0;
    std::array<Bin, 2 * kMost> bins_{};
};

/// Irradiance at the hit from one patch, without shadows: mW/mm^2 times s.
double irradiance(const LitPatch& patch, bool is_single, const SurfaceHit& hit) {
    const Eigen::Vector3d normal = hit.normal.cast<double>();
    const Eigen::Vector3d way = patch.point - hit.point;
    const double r2 = way.squaredNorm(), r = std::sqrt(r2);
    const Eigen::Vector3d to_patch = way / r;
    const double cos_here = normal.dot(to_patch);
    const Eigen::Vector3d patch_normal = patch.normal.normalized();
    const double cos_there = -patch_normal.dot(to_patch);
    if (cos_there <= kGrazing) return 0;  // a piece of the surface's own plane
    double sum = 0;
    if (is_single && patch.radius_mm > kFarEnough * r) {
        const double area = 4 * patch.half_a.cross(patch.half_b).norm();
        sum = patch.diffuse / (std::numbers::pi * area) *
              parallelogram_irradiance(hit.point, normal, patch.point, patch.half_a, patch.half_b);
    } else if (cos_here > 0) {
        sum = patch.diffuse * cos_here * cos_there / (std::numbers::pi * r2);
    }
    if (patch.specular > 0 && cos_here > 0) {
        const double lobe = glossy_lobe(patch_normal, patch.to_light, -to_patch, patch.gloss);
        // A piece is no nearer than its own size: its light is spread over it.
        sum += patch.specular * lobe * cos_there * cos_here /
               std::max(r2, patch.radius_mm * patch.radius_mm);
    }
    return sum;
}

bool is_shaded(const SceneGeometry& geometry, const SurfaceHit& hit, const LitPatch& patch) {
    const Eigen::Vector3d end = patch.on_surface + kLiftMm * patch.normal.normalized();
    // What nearly touches the surface cannot be in its shadow.
    return (end - hit.point).norm() > 4 * kLiftMm && geometry.is_occluded(hit, end);
}

/// Descends the pyramid; use(patch, is_single) gets the patches that stand for the whole.
template <typename Use>
void walk(const LitPatches& patches, const SurfaceHit& hit, int level, int i, int j, Use& use) {
    const LitPatch& patch = patches.at(level, i, j);
    if (patch.diffuse + patch.specular <= 0) return;
    const Eigen::Vector3d way = patch.point - hit.point;
    if (hit.normal.cast<double>().dot(way) < -patch.radius_mm) return;  // below the horizon
    const double r = way.norm();
    const bool bent = patch.normal.norm() < kStraightEnough;
    if (!bent && patch.normal.dot(way) > patch.radius_mm) return;  // turned away
    double far_enough = kFarEnough;
    if (patch.specular > 0) far_enough = std::min(far_enough, patch.gloss / 2);
    if (level == 0 || (!bent && patch.radius_mm < far_enough * r)) {
        use(patch, level == 0);
        return;
    }
    for (int k = 0; k < 4; ++k) walk(patches, hit, level - 1, 2 * i + k / 2, 2 * j + k % 2, use);
}

}  // namespace

BounceLight::BounceLight(const Scene& scene, const Beam& beam, const SceneGeometry& geometry)
    : beam_(beam), geometry_(geometry), patches_(beam, geometry, scene.axis) {
    s_low_ = scene.axis.min;
    s_high_ = scene.axis.max;
    least_rate_ = kLeastLight / (scene.sensor.exposure_us * 1e-6);
}

void BounceLight::add(const SurfaceHit& hit, const Eigen::Vector3d& eye_in_world,
                      std::uint32_t pixel, std::vector<StripeLight>& lights) const {
    if (hit.object < 0 || hit.albedo + hit.specular <= 0) return;
    const Eigen::Vector3d to_eye = (eye_in_world - hit.point).normalized();
    const auto passing = beam_.passing(hit, (s_low_ + s_high_) / 2);
    const double travel = s_high_ - s_low_;
    SweepBins bins(passing ? passing->position : (s_low_ + s_high_) / 2,
                   passing ? 1 / passing->per_s : travel / 64, s_low_ - travel, s_high_ + travel);
    auto use = [&](const LitPatch& patch, bool is_single) {
        const double light = irradiance(patch, is_single, hit);
        if (light <= 0 || is_shaded(geometry_, hit, patch)) return;
        const Eigen::Vector3d to_light = (patch.point - hit.point).normalized();
        bins.add(patch.s_low, patch.s_high, patch.s_sigma,
                 light * reflected_share(hit, to_light, to_eye));
    };
    walk(patches_, hit, patches_.levels() - 1, 0, 0, use);
    bins.for_each([&](double s, double sigma, double amount) {
        const double rate =
            beam_.electrons_per_mw_mm2() * amount / (std::sqrt(2 * std::numbers::pi) * sigma);
        if (rate > least_rate_)
            lights.push_back({s, static_cast<float>(1 / sigma), static_cast<float>(rate), pixel});
    });
}

double BounceLight::dose(const SurfaceHit& hit) const {
    double sum = 0;
    auto use = [&](const LitPatch& patch, bool is_single) {
        if (!is_shaded(geometry_, hit, patch)) sum += irradiance(patch, is_single, hit);
    };
    walk(patches_, hit, patches_.levels() - 1, 0, 0, use);
    return sum;
}

}  // namespace stria
