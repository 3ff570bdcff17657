#include "host/verify/beam.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host/core/errors.h"
#include "host/core/short_number.h"

namespace stria {
namespace {

using Eigen::Vector3d;

/// Distance of the i-th centre from the first at 20 degrees or as stated; of the first itself 0.
CalibratedLength place_of(const Artefact& artefact, std::size_t i) {
    return i == 0 ? CalibratedLength{} : at_temperature(artefact, artefact.lengths[i - 1]);
}

std::vector<FoundSphere> find_all(const ScanPoints& scan, const Artefact& artefact,
                                  std::mt19937& rng) {
    SphereSearch search;
    search.least_diameter_mm = search.greatest_diameter_mm = artefact.diameters[0].mm;
    for (const CalibratedLength& d : artefact.diameters) {
        search.least_diameter_mm = std::min(search.least_diameter_mm, d.mm);
        search.greatest_diameter_mm = std::max(search.greatest_diameter_mm, d.mm);
    }
    const std::size_t wanted = artefact.diameters.size();
    search.most = static_cast<int>(wanted) + 1;
    std::vector<FoundSphere> found = find_spheres(scan, search, rng);
    // One more thing that is round is no sphere of the artefact if its size is another.
    if (found.size() > wanted && (2 * found.back().radius_mm < 0.95 * search.least_diameter_mm ||
                                  2 * found.back().radius_mm > 1.05 * search.greatest_diameter_mm))
        found.pop_back();
    if (found.size() != wanted)
        throw Error("spheres of about " + short_number(search.least_diameter_mm) + " mm: found " +
                    std::to_string(found.size()) + ", the artefact has " + std::to_string(wanted) +
                    (found.size() < wanted ? "; does one hide another from camera or laser?" : ""));
    return found;
}

/// Along the line through the two that are farthest apart.
void order_along_line(std::vector<FoundSphere>& spheres) {
    Vector3d line = Vector3d::Zero();
    for (const FoundSphere& a : spheres)
        for (const FoundSphere& b : spheres)
            if ((b.centre - a.centre).norm() > line.norm()) line = b.centre - a.centre;
    std::sort(spheres.begin(), spheres.end(), [&](const FoundSphere& a, const FoundSphere& b) {
        return a.centre.dot(line) < b.centre.dot(line);
    });
}

/// How far diameters and places differ from the artefact's, mm.
double misfit(const std::vector<FoundSphere>& spheres, const Artefact& artefact) {
    double sum = 0;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        sum += std::pow(2 * spheres[i].radius_mm - artefact.diameters[i].mm, 2);
        const double distance = (spheres[i].centre - spheres[0].centre).norm();
        sum += std::pow(distance - place_of(artefact, i).mm, 2);
    }
    return std::sqrt(sum);
}

void check_places(const std::vector<FoundSphere>& spheres, const Artefact& artefact) {
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        check_found(spheres[i], artefact.diameters[i].mm);
        const double distance = (spheres[i].centre - spheres[0].centre).norm();
        const double calibrated = place_of(artefact, i).mm;
        if (std::abs(distance - calibrated) > 0.02 * calibrated)
            throw Error("sphere " + std::to_string(i + 1) + " is " + short_number(distance) +
                        " mm from the first, the artefact's " + short_number(calibrated) +
                        " mm: another artefact?");
    }
}

/// What the fits add to the uncertainty (one standard deviation) of the distance between centres.
double distance_sigma(const MeasuredSphere& a, const MeasuredSphere& b) {
    const Vector3d along = (b.centre - a.centre).normalized();
    return std::sqrt(along.dot((a.centre_covariance + b.centre_covariance) * along));
}

BeamLength between(const std::vector<MeasuredSphere>& spheres, const Artefact& artefact,
                   std::size_t from, std::size_t to) {
    if (!(from < to && to < spheres.size()))
        throw std::invalid_argument("spheres " + std::to_string(from) + " to " +
                                    std::to_string(to) + " of " + std::to_string(spheres.size()));
    const CalibratedLength near = place_of(artefact, from), far = place_of(artefact, to);
    BeamLength length;
    length.from = from;
    length.to = to;
    length.calibrated_mm = far.mm - near.mm;
    length.measured_mm = (spheres[to].centre - spheres[from].centre).norm();
    length.expanded_mm = combined(
        {near.expanded_mm, far.expanded_mm, 2 * distance_sigma(spheres[from], spheres[to])});
    return length;
}

}  // namespace

MeasuredBeam measure_beam(const ScanPoints& scan, const Artefact& artefact,
                          const SphereRegionOptions& options, std::mt19937& rng) {
    if (artefact.diameters.size() < 2 || artefact.lengths.size() + 1 != artefact.diameters.size())
        throw std::invalid_argument("measure_beam: " + std::to_string(artefact.diameters.size()) +
                                    " diameters and " + std::to_string(artefact.lengths.size()) +
                                    " lengths, expected n >= 2 and n - 1");
    std::vector<FoundSphere> spheres = find_all(scan, artefact, rng);
    order_along_line(spheres);
    std::vector<FoundSphere> turned(spheres.rbegin(), spheres.rend());
    if (misfit(turned, artefact) < misfit(spheres, artefact)) std::swap(turned, spheres);
    check_places(spheres, artefact);
    MeasuredBeam beam;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const SphereRegion region = sphere_region(scan, spheres[i], options);
        const double diameter = at_temperature(artefact, artefact.diameters[i]).mm;
        beam.fixed.push_back(measure_sphere(scan, region, diameter));
        beam.free.push_back(measure_sphere(scan, region));
    }
    return beam;
}

BeamLength centre_distance(const MeasuredBeam& beam, const Artefact& artefact, std::size_t from,
                           std::size_t to) {
    return between(beam.fixed, artefact, from, to);
}

BeamLength length_over(const MeasuredBeam& beam, const Artefact& artefact, std::size_t from,
                       std::size_t to) {
    BeamLength length = between(beam.free, artefact, from, to);
    for (const std::size_t i : {from, to}) {
        const CalibratedLength diameter = at_temperature(artefact, artefact.diameters[i]);
        length.calibrated_mm += diameter.mm / 2;
        length.measured_mm += beam.free[i].diameter_mm / 2;
        length.expanded_mm = combined(
            {length.expanded_mm, diameter.expanded_mm / 2, beam.free[i].diameter_sigma_mm});
    }
    return length;
}

}  // namespace stria
