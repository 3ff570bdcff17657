#include "calib/stripe_line.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>

#include "firmware/core/median.h"

namespace stria {
namespace {

constexpr std::size_t kLeastPoints = 20;
constexpr double kLeastCover = 0.3;  // of the line's way over the board
constexpr double kNearPx = 1.5;      // from the line that most peaks agree with
constexpr int kPairs = 400;
constexpr double kHuber = 1.345, kFarOff = 4;  // standard deviations

/// A peak on the board.
struct OnBoard {
    Eigen::Vector2d at;
    Eigen::Vector2d per_px;  ///< mm on the board for a px along the peak's `across`
    double sigma_px;
};

/// a + b t mm beside the line through `centre` along `along`.
struct Line {
    Eigen::Vector2d centre, along;
    Eigen::Vector2d normal() const { return {-along.y(), along.x()}; }
    double off(const Eigen::Vector2d& p) const { return normal().dot(p - centre); }
    double at(const Eigen::Vector2d& p) const { return along.dot(p - centre); }
};

bool one_colour_around(const CameraModel& camera, const Rigid3& pose, const BoardColours& colours,
                       const StripePeak& peak) {
    int low = 255, high = 0;
    const double width = std::max(1.0, peak.width_px);
    for (int k = -6; k <= 6; ++k) {
        const auto p = seen_on_board(camera, pose, peak.pixel + 0.5 * k * width * peak.across);
        const int colour = p ? colours.at(*p) : 128;
        low = std::min(low, colour);
        high = std::max(high, colour);
    }
    return low > 200 || high < 55;
}

std::vector<OnBoard> on_board(const std::vector<StripePeak>& peaks, const CameraModel& camera,
                              const Rigid3& pose, const BoardColours& colours) {
    std::vector<OnBoard> found;
    for (const StripePeak& peak : peaks) {
        const auto at = seen_on_board(camera, pose, peak.pixel);
        if (!at || !colours.is_inside(*at) || !one_colour_around(camera, pose, colours, peak))
            continue;
        const auto after = seen_on_board(camera, pose, peak.pixel + 0.5 * peak.across);
        const auto before = seen_on_board(camera, pose, peak.pixel - 0.5 * peak.across);
        if (after && before) found.push_back({*at, *after - *before, peak.sigma_px});
    }
    return found;
}

double sigma_mm(const OnBoard& point, const Line& line) {
    return std::max(1e-9, std::abs(line.normal().dot(point.per_px)) * point.sigma_px);
}

bool is_near(const OnBoard& point, const Line& line) {
    return std::abs(line.off(point.at)) < kNearPx * std::abs(line.normal().dot(point.per_px));
}

std::optional<Line> line_most_agree_with(const std::vector<OnBoard>& points) {
    if (points.size() < 2) return std::nullopt;
    std::mt19937 rng(1);
    std::optional<Line> best;
    std::ptrdiff_t most = 0;
    for (int pair = 0; pair < kPairs; ++pair) {
        const Eigen::Vector2d a = points[rng() % points.size()].at;
        const Eigen::Vector2d way = points[rng() % points.size()].at - a;
        if (!(way.norm() > 0)) continue;
        const Line line{a, way.normalized()};
        const auto agree = std::count_if(points.begin(), points.end(),
                                         [&](const OnBoard& p) { return is_near(p, line); });
        if (agree > most) {
            most = agree;
            best = line;
        }
    }
    return best;
}

/// One step of weighted least squares over offset and slope; `weights` multiply 1 / sigma^2.
/// Returns the information of (offset, slope per mm) at the line's centre.
Eigen::Matrix2d improve(Line& line, const std::vector<OnBoard>& points,
                        const std::vector<double>& weights) {
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double weight = weights[i] / std::pow(sigma_mm(points[i], line), 2);
        const Eigen::Vector2d row(1, line.at(points[i].at));
        information += weight * row * row.transpose();
        gradient += weight * line.off(points[i].at) * row;
    }
    const Eigen::Vector2d step = information.ldlt().solve(gradient);
    if (!step.allFinite()) return information;
    line.centre += step.x() * line.normal();
    line.along = (line.along + step.y() * line.normal()).normalized();
    return information;
}

std::vector<double> whitened(const Line& line, const std::vector<OnBoard>& points) {
    std::vector<double> residuals;
    for (const OnBoard& p : points) residuals.push_back(line.off(p.at) / sigma_mm(p, line));
    return residuals;
}

double robust_scale(std::vector<double> residuals) {
    for (double& r : residuals) r = std::abs(r);
    return std::max(1.0, 1.4826 * median(std::move(residuals)));
}

void centre_on(Line& line, const std::vector<OnBoard>& points) {
    double sum = 0;
    for (const OnBoard& p : points) sum += line.at(p.at);
    line.centre += sum / static_cast<double>(points.size()) * line.along;
}

/// Robust, then without what is far off, then plain.
Eigen::Matrix2d fit(Line& line, std::vector<OnBoard>& points) {
    std::erase_if(points, [&](const OnBoard& p) { return !is_near(p, line); });
    if (points.size() < 3) return Eigen::Matrix2d::Zero();
    centre_on(line, points);
    for (int round = 0; round < 8; ++round) {
        const auto residuals = whitened(line, points);
        const double scale = kHuber * robust_scale(residuals);
        std::vector<double> weights;
        for (double r : residuals) weights.push_back(std::min(1.0, scale / std::abs(r)));
        improve(line, points, weights);
    }
    const double limit = kFarOff * robust_scale(whitened(line, points));
    std::erase_if(points, [&](const OnBoard& p) {
        return std::abs(line.off(p.at)) > limit * sigma_mm(p, line);
    });
    centre_on(line, points);
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    for (int round = 0; round < 4; ++round)
        information = improve(line, points, std::vector<double>(points.size(), 1.0));
    return information;
}

/// Length (mm) of the line within the board's outermost corners.
double way_over_board(const Line& line, const BoardColours& colours) {
    double first = -1e9, last = 1e9;
    for (int axis = 0; axis < 2; ++axis) {
        const double speed = line.along[axis];
        if (std::abs(speed) < 1e-12) continue;
        const double a = (colours.min_mm()[axis] - line.centre[axis]) / speed;
        const double b = (colours.max_mm()[axis] - line.centre[axis]) / speed;
        first = std::max(first, std::min(a, b));
        last = std::min(last, std::max(a, b));
    }
    return last - first;
}

std::string too_few(std::size_t found) {
    return "stripe not crossing: " + std::to_string(found) +
           " stripe points in line on the board, at least " + std::to_string(kLeastPoints) +
           " needed";
}

}  // namespace

std::vector<StripePeak> stripe_peaks(const std::vector<Pulse>& peaks, bool columns) {
    std::vector<StripePeak> found;
    for (const Pulse& peak : peaks) {
        if (!(peak.sigma > 0) || (peak.flags & kPulseImageBorder) != 0) continue;
        StripePeak out{{peak.u, peak.v}, peak.sigma, peak.width, Eigen::Vector2d::UnitX()};
        if (columns) {
            std::swap(out.pixel.x(), out.pixel.y());
            out.across = Eigen::Vector2d::UnitY();
        }
        found.push_back(out);
    }
    return found;
}

StripeLine stripe_line_on_board(const std::vector<StripePeak>& peaks, const CameraModel& camera,
                                const Rigid3& camera_from_board, const BoardColours& colours) {
    StripeLine result;
    std::vector<OnBoard> points = on_board(peaks, camera, camera_from_board, colours);
    auto line = line_most_agree_with(points);
    const Eigen::Matrix2d information = line ? fit(*line, points) : Eigen::Matrix2d::Zero();
    if (!line || points.size() < kLeastPoints) {
        result.refusal = too_few(line ? points.size() : 0);
        return result;
    }
    double first = 1e9, last = -1e9, sum = 0, chi_square = 0;
    for (const OnBoard& p : points) {
        first = std::min(first, line->at(p.at));
        last = std::max(last, line->at(p.at));
        sum += std::pow(line->off(p.at), 2);
        chi_square += std::pow(line->off(p.at) / sigma_mm(p, *line), 2);
        result.points.push_back(p.at);
    }
    const double cover = (last - first) / way_over_board(*line, colours);
    if (!(cover >= kLeastCover)) {
        result.refusal = "stripe not crossing: it covers " +
                         std::to_string(std::lround(100 * cover)) +
                         " % of its way over the board, at least 30 % needed";
        return result;
    }
    result.ends[0] = line->centre + first * line->along;
    result.ends[1] = line->centre + last * line->along;
    result.normal = line->normal();
    result.rms_mm = std::sqrt(sum / static_cast<double>(points.size()));
    result.chi_square = chi_square / static_cast<double>(points.size() - 2);
    Eigen::Matrix2d ends;
    ends << 1, first, 1, last;
    result.covariance =
        std::max(1.0, result.chi_square) * ends * information.inverse() * ends.transpose();
    return result;
}

}  // namespace stria
