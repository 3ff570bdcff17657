#include "tests/firmware/stripe/lit_profile.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "firmware/stripe/spacetime.h"
#include "firmware/stripe/spatial.h"
#include "tests/firmware/stripe/localisation.h"

namespace stria::test {
namespace {

constexpr TimeNs kPeriodNs = 5'000'000;

SensorNoise stated_noise() { return sensor_for(LitProfile::kHeight, 100, false); }

/// What a line of sight meets: where, and how much of the beam's light that returns.
struct Seen {
    double x = 0, share = 0;
};

std::optional<Seen> seen_along(const LitProfile& p, double u) {
    const double c = std::cos(p.angle), s = std::sin(p.angle);
    std::optional<Seen> nearest;
    double nearest_depth = -1e300;
    for (const ProfileSegment& segment : p.segments) {
        const double u0 = segment.x0 * c - segment.z0 * s, u1 = segment.x1 * c - segment.z1 * s;
        const double along = (u - u0) / (u1 - u0);
        if (!(along >= 0 && along <= 1)) continue;
        const double x = segment.x0 + along * (segment.x1 - segment.x0);
        const double z = segment.height_at(x);
        if (x * s + z * c <= nearest_depth) continue;
        nearest_depth = x * s + z * c;
        const bool lit =
            std::none_of(p.segments.begin(), p.segments.end(), [&](const ProfileSegment& other) {
                return x > other.x0 && x < other.x1 && other.height_at(x) > z + 1e-9;
            });
        const double slope = (segment.z1 - segment.z0) / (segment.x1 - segment.x0);
        nearest = Seen{x, lit ? 1.0 / std::sqrt(1.0 + slope * slope) : 0.0};
    }
    return nearest;
}

template <typename Function>
void for_bright(const std::vector<double>& sums, Function function) {
    const double least = 0.1 * *std::max_element(sums.begin(), sums.end());
    for (std::size_t i = 0; i < sums.size(); ++i)
        if (sums[i] >= least) function(i);
}

}  // namespace

LitProfile corner_profile(double degrees, bool roof, double ratio) {
    LitProfile p;
    p.footprint = ratio * p.beam_width;
    const double fall = (roof ? -1 : 1) / std::tan(degrees * M_PI / 360);
    constexpr double kSide = 90;
    p.segments = {{-kSide, kSide * fall, 0, 0}, {0, 0, kSide, kSide * fall}};
    return p;
}

LitProfile strip_profile(double ratio) {
    LitProfile p;
    p.footprint = ratio * p.beam_width;
    p.beam_step = p.beam_width / 8;
    const double half = 3 * p.beam_width, floor = -10 * p.beam_width;
    p.segments = {{-half, 0, half, 0}, {-150, floor, 150, floor}};
    return p;
}

int LitProfile::frames() const { return 1 + static_cast<int>(2 * reach / beam_step); }

double LitProfile::height_of(double x, double u) const {
    return (x * std::cos(angle) - u) / std::sin(angle);
}

double LitProfile::distance(double x, double z) const {
    double least = 1e300;
    for (const ProfileSegment& s : segments) {
        const double dx = s.x1 - s.x0, dz = s.z1 - s.z0;
        const double along =
            std::clamp(((x - s.x0) * dx + (z - s.z0) * dz) / (dx * dx + dz * dz), 0.0, 1.0);
        least = std::min(least, std::hypot(x - s.x0 - along * dx, z - s.z0 - along * dz));
    }
    return least;
}

namespace {

constexpr int kFine = 6, kFineReach = 4 * kFine;  // samples a width of the blur; of all of it
constexpr int kFineCount = 2 * kFineReach + 1;

/// Of every pixel the lines of sight within its footprint, weighted.
std::vector<Seen> footprints(const LitProfile& p) {
    const double step = p.footprint * std::cos(p.angle) / kFine;
    double weights = 0;
    for (int i = -kFineReach; i <= kFineReach; ++i)
        weights += std::exp(-0.5 * i * i / double(kFine * kFine));
    std::vector<Seen> all;
    for (int y = 0; y < LitProfile::kRows; ++y) {
        for (int x = 0; x < LitProfile::kWidth; ++x) {
            for (int i = -kFineReach; i <= kFineReach; ++i) {
                Seen seen = seen_along(p, p.u_of(x, y) + i * step).value_or(Seen{});
                seen.share *= std::exp(-0.5 * i * i / double(kFine * kFine)) / weights;
                all.push_back(seen);
            }
        }
    }
    return all;
}

}  // namespace

ProfileSweep::ProfileSweep(const LitProfile& profile) : profile_(profile) {
    const std::vector<Seen> seen = footprints(profile);
    for (int k = 0; k < profile.frames(); ++k) {
        std::vector<double> light(seen.size() / kFineCount, 0.0);
        for (std::size_t i = 0; i < seen.size(); ++i) {
            const double z = (seen[i].x - profile.beam_at(k)) / profile.beam_width;
            if (seen[i].share > 0 && std::abs(z) < 8)
                light[i / kFineCount] +=
                    LitProfile::kHeight * seen[i].share * std::exp(-0.5 * z * z);
        }
        light_.push_back(std::move(light));
    }
}

Frame ProfileSweep::frame(int k) const {
    Frame out;
    constexpr int kWidth = LitProfile::kWidth, kRows = LitProfile::kRows;
    resize(out, kWidth, kRows, 16);
    out.sequence = static_cast<std::uint32_t>(k);
    out.exposure_start_ns = k * kPeriodNs;
    out.exposure_ns = kPeriodNs / 10;
    const std::vector<double>& values = light_[static_cast<std::size_t>(k)];
    for (int i = 0; i < kRows * kWidth; ++i)
        set_sample(out, i % kWidth, i / kWidth,
                   static_cast<int>(std::lround(values[static_cast<std::size_t>(i)])));
    return out;
}

std::vector<ProfilePoint> ProfileSweep::spatial_moments() const {
    const LitProfile& p = profile_;
    std::vector<ProfilePoint> points;
    for (int k = 0; k < p.frames(); ++k) {
        const std::vector<double>& light = light_[static_cast<std::size_t>(k)];
        std::vector<double> sums(LitProfile::kRows), moments(LitProfile::kRows);
        for (std::size_t i = 0; i < light.size(); ++i) {
            const std::size_t y = i / LitProfile::kWidth;
            sums[y] += light[i];
            moments[y] +=
                light[i] * p.u_of(static_cast<double>(i % LitProfile::kWidth), static_cast<int>(y));
        }
        for_bright(sums, [&](std::size_t y) {
            points.push_back({p.beam_at(k), p.height_of(p.beam_at(k), moments[y] / sums[y])});
        });
    }
    return points;
}

std::vector<ProfilePoint> ProfileSweep::spacetime_moments() const {
    const LitProfile& p = profile_;
    std::vector<double> sums(LitProfile::kRows * LitProfile::kWidth), moments(sums.size());
    for (int k = 0; k < p.frames(); ++k) {
        const std::vector<double>& light = light_[static_cast<std::size_t>(k)];
        for (std::size_t i = 0; i < light.size(); ++i) {
            sums[i] += light[i];
            moments[i] += light[i] * p.beam_at(k);
        }
    }
    std::vector<ProfilePoint> points;
    for_bright(sums, [&](std::size_t i) {
        const double u = p.u_of(static_cast<double>(i % LitProfile::kWidth),
                                static_cast<int>(i / LitProfile::kWidth));
        points.push_back({moments[i] / sums[i], p.height_of(moments[i] / sums[i], u)});
    });
    return points;
}

std::vector<ProfilePoint> ProfileSweep::spatial_peaks(int most_a_row) const {
    const LitProfile& p = profile_;
    const SpatialOptions options{
        .max_peaks_per_row = most_a_row, .max_misfit = 1, .method = PeakMethod::centre_of_gravity};
    std::vector<ProfilePoint> points;
    for (int k = 0; k < p.frames(); ++k) {
        const double beam = p.beam_at(k);
        for (const Pulse& peak : find_peaks(frame(k), stated_noise(), options))
            points.push_back({beam, p.height_of(beam, p.u_of(static_cast<double>(peak.u),
                                                             static_cast<int>(peak.v)))});
    }
    return points;
}

std::vector<ProfilePoint> ProfileSweep::spacetime_pulses() const {
    const LitProfile& p = profile_;
    SpacetimeAnalyser analyser(LitProfile::kWidth, LitProfile::kRows, 16, stated_noise());
    const TimeNs start = frame(0).row_time(0);
    for (int k = 0; k < p.frames(); ++k) analyser.add(frame(k));
    std::vector<ProfilePoint> points;
    for (const Pulse& pulse : analyser.finish().pulses) {
        const double x = p.beam_at(static_cast<double>(pulse.t_ns - start) / double(kPeriodNs));
        points.push_back(
            {x, p.height_of(x, p.u_of(static_cast<double>(pulse.u), static_cast<int>(pulse.v)))});
    }
    return points;
}

}  // namespace stria::test
