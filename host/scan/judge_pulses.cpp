#include "host/scan/judge_pulses.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "host/geometry/parallel.h"

namespace stria {
namespace {

constexpr int kReach = 2;              ///< pixels to each side that a gradient is taken from
constexpr double kSteepest = 4;        ///< steps of s a pixel, in those of an even surface
constexpr double kLinkSigmas = 4;      ///< by which neighbours may differ besides
constexpr double kFacingSigmas = 3;    ///< that a surface must be turned away by
constexpr int kFewestNeighbours = 4;   ///< for a gradient
constexpr int kThroughgoing = 6;       ///< of 8 neighbours that continue a surface through a pixel
constexpr int kFewestMerging = 2;      ///< merging cells nearby that make a cell doubtful
constexpr float kMisfit = 2;           ///< chi-square that lets merging light reach farther
constexpr double kFarthest = 8;        ///< pixels from which merging light is taken to reach
constexpr double kWider = 1.03;        ///< width over the usual one, and
constexpr float kSlightMisfit = 1.5F;  ///< chi-square, of a pulse that merging light may be in

struct Grid {
    const std::vector<std::vector<PulseCandidate>>& cells;
    int width, height;
    double axis_sigma_s;

    double sigma_s(const PulseCandidate& c) const {
        return std::hypot(axis_sigma_s,
                          static_cast<double>(c.pulse->sigma) * 1e-9 * std::abs(c.pulse->ds_dt));
    }
};

/// How much s changes a pixel along u and v on a surface of even range about the point.
Eigen::Vector2d even_gradient(const Triangulation& hit) {
    const double along = hit.ray_in_scan.dot(hit.d_point_d_s);
    if (std::abs(along) < 1e-12) return {0, 0};
    return {-hit.ray_in_scan.dot(hit.d_point_d_u) / along,
            -hit.ray_in_scan.dot(hit.d_point_d_v) / along};
}

/// The candidate of a cell whose s is nearest; null if it cannot be the same surface.
const PulseCandidate* continuation(const Grid& grid, const PulseCandidate& from, double even_step,
                                   int x, int y, int dx, int dy) {
    if (x + dx < 0 || x + dx >= grid.width || y + dy < 0 || y + dy >= grid.height) return nullptr;
    const auto& cell =
        grid.cells[static_cast<std::size_t>(y + dy) * static_cast<std::size_t>(grid.width) +
                   static_cast<std::size_t>(x + dx)];
    const PulseCandidate* nearest = nullptr;
    double least = 1e300;
    for (const PulseCandidate& c : cell) {
        const double off = std::abs(c.pulse->s - from.pulse->s);
        if (c.pulse->laser_id != from.pulse->laser_id || off >= least) continue;
        nearest = &c;
        least = off;
    }
    if (!nearest) return nullptr;
    const double distance = std::max(std::abs(dx), std::abs(dy));
    const double reach = kSteepest * even_step * distance +
                         kLinkSigmas * std::hypot(grid.sigma_s(from), grid.sigma_s(*nearest));
    return least <= reach ? nearest : nullptr;
}

struct Slope {
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();  ///< of s, per pixel
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
    bool is_known = false;
};

/// Plane through a candidate and what continues it; counts the nearest 8 that do.
Slope slope_about(const Grid& grid, const PulseCandidate& c, int x, int y, int& support) {
    const double even_step = even_gradient(c.hit).norm();
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    double sum_variance = 0;
    int count = 0;
    support = 0;
    for (int dy = -kReach; dy <= kReach; ++dy)
        for (int dx = -kReach; dx <= kReach; ++dx) {
            if (dx == 0 && dy == 0) continue;
            const PulseCandidate* next = continuation(grid, c, even_step, x, y, dx, dy);
            if (!next) continue;
            if (std::abs(dx) <= 1 && std::abs(dy) <= 1) ++support;
            const Eigen::Vector3d row(dx, dy, 1);
            normal += row * row.transpose();
            right += row * (next->pulse->s - c.pulse->s);
            sum_variance += grid.sigma_s(*next) * grid.sigma_s(*next);
            ++count;
        }
    Slope slope;
    if (count < kFewestNeighbours) return slope;
    normal(2, 2) += 1;  // the candidate itself, at 0
    const double variance = (sum_variance + grid.sigma_s(c) * grid.sigma_s(c)) / (count + 1);
    if (normal.determinant() < 1e-6) return slope;
    const Eigen::Matrix3d inverse = normal.inverse();
    slope.gradient = (inverse * right).head<2>();
    slope.covariance = variance * inverse.topLeftCorner<2, 2>();
    slope.is_known = true;
    return slope;
}

/// Whether the surface of that slope shows its back to the laser. Its normal is
/// (P_u + P_s s_u) x (P_v + P_s s_v), linear in the gradient since P_s runs along the ray.
bool is_turned_away(const PulseCandidate& c, const Slope& slope, const Channel& channel) {
    if (!slope.is_known) return false;
    const Triangulation& hit = c.hit;
    const Rigid3 scan = scan_from_camera(channel, c.pulse->s);
    const Eigen::Vector3d to_laser =
        (scan * sheet_at(channel, c.pulse->s).apex - hit.point_in_scan).normalized();
    const Eigen::Vector3d even = hit.d_point_d_u.cross(hit.d_point_d_v);
    const Eigen::Vector3d by_u = hit.d_point_d_s.cross(hit.d_point_d_v);
    const Eigen::Vector3d by_v = hit.d_point_d_u.cross(hit.d_point_d_s);
    const double to_camera = even.dot(hit.ray_in_scan) > 0 ? -1 : 1;
    const Eigen::Vector2d per_gradient(to_camera * by_u.dot(to_laser),
                                       to_camera * by_v.dot(to_laser));
    const double facing = to_camera * even.dot(to_laser) + per_gradient.dot(slope.gradient);
    const double sigma = std::sqrt(per_gradient.dot(slope.covariance * per_gradient));
    return facing < -kFacingSigmas * sigma;
}

/// Whether two cells or more within reach merge at least so surely.
bool merges_near(const std::vector<Merging>& merging, Merging least, const Grid& grid, int x, int y,
                 int reach) {
    int count = 0;
    for (int j = std::max(0, y - reach); j <= std::min(grid.height - 1, y + reach); ++j)
        for (int i = std::max(0, x - reach); i <= std::min(grid.width - 1, x + reach); ++i)
            count += merging[static_cast<std::size_t>(j) * static_cast<std::size_t>(grid.width) +
                             static_cast<std::size_t>(i)] >= least;
    return count >= kFewestMerging;
}

/// Pixels over which the beam's standard deviation reaches on an even surface.
double beam_in_pixels(const PulseCandidate& c) {
    const double width_s = static_cast<double>(c.pulse->width) * 1e-9 * std::abs(c.pulse->ds_dt);
    return width_s / std::max(even_gradient(c.hit).norm(), 1e-12);
}

bool is_in_merging_light(const std::vector<Merging>& merging, const PulseCandidate& chosen,
                         const Grid& grid, int x, int y) {
    const float misfit = chosen.pulse->chi_square;
    const double beam_px = std::min(beam_in_pixels(chosen), kFarthest);
    const int far = std::max(1, static_cast<int>(std::lround(beam_px)));
    const int near = std::max(1, static_cast<int>(std::lround(beam_px / 2)));
    if (merges_near(merging, Merging::surely, grid, x, y, misfit > kMisfit ? far : near))
        return true;
    const bool is_one = (chosen.pulse->flags & kPulseOverlapping) == 0;
    if (is_one && merges_near(merging, Merging::soon, grid, x, y, near)) return true;
    return chosen.width_ratio > kWider && misfit > kSlightMisfit &&
           merges_near(merging, Merging::maybe, grid, x, y, far);
}

bool is_doubtful(const PulseCandidate& c) { return c.turned_away || c.contradicted; }

bool choose(std::vector<PulseCandidate>& cell) {
    for (PulseCandidate& c : cell) {
        c.flags = static_cast<std::uint16_t>(c.pulse->flags & ~kPulseGhostSuspected);
        if (c.apart > kParted) c.flags = static_cast<std::uint16_t>(c.flags & ~kPulseOverlapping);
        if (is_doubtful(c)) c.flags |= kPulseGhostSuspected;
    }
    std::stable_sort(cell.begin(), cell.end(), [](const auto& a, const auto& b) {
        if (is_doubtful(a) != is_doubtful(b)) return is_doubtful(b);
        if (a.turned_away != b.turned_away) return b.turned_away;
        if (a.support != b.support) return a.support > b.support;
        return a.pulse->amplitude > b.pulse->amplitude;
    });
    if (cell.size() < 2 || is_doubtful(cell[1])) return true;
    if (cell[1].support < kThroughgoing) return true;
    cell[0].flags |= kPulseGhostSuspected;
    return false;
}

}  // namespace

double widths_apart(const Pulse& pulse, std::span<const Pulse> cell) {
    double least = std::numeric_limits<double>::infinity();
    if ((pulse.flags & kPulseOverlapping) == 0) return least;
    for (const Pulse& other : cell) {
        if (&other == &pulse || (other.flags & kPulseOverlapping) == 0) continue;
        const double width = std::sqrt(0.5) * std::hypot(static_cast<double>(pulse.width),
                                                         static_cast<double>(other.width));
        least = std::min(least, std::abs(static_cast<double>(other.t_ns - pulse.t_ns)) / width);
    }
    return std::isinf(least) ? 0 : least;
}

JudgeCounts judge_swept_pulses(std::vector<std::vector<PulseCandidate>>& cells, int width,
                               int height, const std::vector<Merging>& merging,
                               const ScannerModel& model, std::uint8_t camera_id,
                               double axis_sigma_s) {
    const Grid grid{cells, width, height, axis_sigma_s};
    // First all slopes from what is there, then the choices: the order of cells does not matter.
    parallel_for_blocks(
        static_cast<std::size_t>(height), 4, [&](std::size_t begin, std::size_t end) {
            for (std::size_t y = begin; y < end; ++y)
                for (int x = 0; x < width; ++x)
                    for (PulseCandidate& c :
                         cells[y * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)]) {
                        const Channel* channel = find_channel(model, camera_id, c.pulse->laser_id);
                        int support = 0;
                        const Slope slope = slope_about(grid, c, x, static_cast<int>(y), support);
                        c.support = support;
                        c.turned_away = is_turned_away(c, slope, *channel);
                    }
        });
    JudgeCounts counts;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        auto& cell = cells[i];
        if (cell.empty()) continue;
        for (const PulseCandidate& c : cell) counts.turned_away += c.turned_away;
        counts.ambiguous += !choose(cell);
        const auto x = static_cast<int>(i % static_cast<std::size_t>(width));
        const auto y = static_cast<int>(i / static_cast<std::size_t>(width));
        if (!is_in_merging_light(merging, cell.front(), grid, x, y)) continue;
        ++counts.near_merging;
        for (PulseCandidate& c : cell) c.flags |= kPulseOverlapping;
    }
    return counts;
}

}  // namespace stria
