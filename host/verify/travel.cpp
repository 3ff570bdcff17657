#include "host/verify/travel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "host/core/errors.h"

namespace stria {
namespace {

using Eigen::Vector3d;

constexpr double kMostTilt_rad = 0.035;  // 2 deg: a cosine of 6e-4

double mean_of(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}

/// Mean normal of the planes, all turned to the first one's side.
Vector3d mean_normal(const std::vector<MeasuredPlane>& planes) {
    Vector3d sum = Vector3d::Zero();
    for (const MeasuredPlane& plane : planes)
        sum += plane.normal.dot(planes[0].normal) < 0 ? -plane.normal : plane.normal;
    const Vector3d normal = sum.normalized();
    for (const MeasuredPlane& plane : planes)
        if (std::abs(plane.normal.dot(normal)) < std::cos(kMostTilt_rad))
            throw Error(
                "the target tilts by more than 2 deg between scans: expected one that "
                "travels along its normal");
    return normal;
}

/// Where each plane meets the line along the normal through the middle of all of them.
std::vector<double> places_along(const std::vector<MeasuredPlane>& planes, const Vector3d& normal) {
    Vector3d middle = Vector3d::Zero();
    for (const MeasuredPlane& plane : planes)
        middle += plane.centre / static_cast<double>(planes.size());
    std::vector<double> places;
    for (const MeasuredPlane& plane : planes)
        places.push_back(plane.normal.dot(plane.centre - middle) / plane.normal.dot(normal));
    return places;
}

/// The travel counts towards or away from the scanner, whichever the planes show.
void turn_along(std::vector<double>& places, const std::vector<double>& travelled) {
    const double mean = mean_of(travelled);
    double product = 0;
    for (std::size_t i = 0; i < places.size(); ++i) product += places[i] * (travelled[i] - mean);
    if (product < 0)
        for (double& place : places) place = -place;
}

}  // namespace

TravelFigures travel_figures(const std::vector<MeasuredPlane>& planes,
                             const std::vector<double>& travelled) {
    std::map<double, std::vector<double>> errors_at;
    for (const double place : travelled) errors_at[place];
    if (errors_at.size() < 3)
        throw Error("the target was scanned at " + std::to_string(errors_at.size()) +
                    " places, expected at least 3");
    std::vector<double> places = places_along(planes, mean_normal(planes));
    turn_along(places, travelled);
    const double shift = mean_of(places) - mean_of(travelled);

    TravelFigures figures;
    for (std::size_t i = 0; i < planes.size(); ++i) {
        TravelStep step;
        step.true_mm = travelled[i];
        step.measured_mm = places[i] - shift;
        step.error_mm = step.measured_mm - step.true_mm;
        step.point_sigma_mm = planes[i].form.sigma_mm;
        step.plane_sigma_mm =
            step.point_sigma_mm / std::sqrt(static_cast<double>(planes[i].form.points_used));
        errors_at[step.true_mm].push_back(step.error_mm);
        figures.steps.push_back(step);
    }
    double squares = 0, spread = 0, product = 0;
    const double middle = mean_of(travelled);
    for (const auto& [place, errors] : errors_at) {
        const double mean = mean_of(errors);
        figures.linearity_mm = std::max(figures.linearity_mm, std::abs(mean));
        for (const double error : errors) {
            squares += (error - mean) * (error - mean);
            spread += (place - middle) * (place - middle);
            product += (place - middle) * error;
        }
        figures.repeats += errors.size() - 1;
    }
    figures.range_mm = errors_at.rbegin()->first - errors_at.begin()->first;
    figures.scale_error = product / spread;
    figures.repeatability_mm = figures.repeats > 0
                                   ? std::sqrt(squares / static_cast<double>(figures.repeats))
                                   : std::numeric_limits<double>::quiet_NaN();
    return figures;
}

}  // namespace stria
