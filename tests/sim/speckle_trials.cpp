#include "tests/sim/speckle_trials.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

#include "firmware/stripe/spacetime.h"
#include "host/scan/centre_of_light.h"

namespace stria {
namespace {

constexpr double kDnOfMean = 3000;  ///< at the line's centre; 16 bits hold 21 times the mean
constexpr TimeNs kPeriod = 1'000'000;
/// Shot noise of 3000 electrons at the mean, so that the fit weighs samples as a camera's.
constexpr SensorNoise kNoise{.gain_e_per_dn = 1, .read_noise_e = 5, .black_dn = 0};

/// Sums of squares that become root mean squares.
struct Sums {
    double weight = 0, weighted = 0, squares = 0;
    int count = 0;
    void add(double error, double by) {
        weight += by;
        weighted += by * error * error;
        squares += error * error;
        ++count;
    }
    SpeckleError root() const { return {std::sqrt(weighted / weight), std::sqrt(squares / count)}; }
};

/// One surface and the line's crossing of it.
struct Crossing {
    int columns, rows, frames;  ///< frames until the line, cyclic, is where it began
    double pixel_mm, step_mm, sigma_mm;
    std::vector<std::vector<double>> pictures;
};

Crossing cross(const CoherentSurface& surface, const SpeckleTrials& trials) {
    Crossing crossing{trials.view.columns,
                      trials.view.rows,
                      0,
                      trials.view.pixel_mm,
                      0,
                      trials.line.sigma_mm,
                      {}};
    const double way_mm = surface.width_mm();
    crossing.frames =
        static_cast<int>(std::ceil(way_mm / (trials.step_sigmas * crossing.sigma_mm)));
    crossing.step_mm = way_mm / crossing.frames;
    for (int k = 0; k < crossing.frames; ++k)
        crossing.pictures.push_back(
            surface.pixels_of(surface.lit_by(trials.line, k * crossing.step_mm)));
    return crossing;
}

Frame frame_of(const std::vector<double>& picture, const Crossing& crossing, int k) {
    Frame frame;
    resize(frame, crossing.columns, crossing.rows, 16);
    for (std::size_t i = 0; i < picture.size(); ++i) {
        const auto dn = static_cast<std::uint16_t>(
            std::clamp(std::floor(picture[i] * kDnOfMean + 0.5), 0.0, 65535.0));
        std::memcpy(frame.bytes.data() + 2 * i, &dn, 2);
    }
    frame.laser_power = 1;
    frame.exposure_ns = 1000;
    frame.exposure_start_ns = k * kPeriod - 500;
    frame.sequence = static_cast<std::uint32_t>(k);
    return frame;
}

/// One crossing and a half, so that every pixel sees the line come and go; pulses are found as on
/// the scanner.
PulseMap pulses_of(const Crossing& crossing) {
    SpacetimeAnalyser analyser(crossing.columns, crossing.rows, 16, kNoise);
    for (int k = 0; k < crossing.frames + crossing.frames / 2; ++k)
        analyser.add(frame_of(crossing.pictures[static_cast<std::size_t>(k % crossing.frames)],
                              crossing, k));
    return analyser.finish();
}

/// First moment of a pixel's light about its own place, mm, and its light.
struct Moment {
    double at_mm, light;
};
Moment moment_over_time(const Crossing& crossing, std::size_t pixel, double place_mm) {
    double sum = 0, first = 0;
    for (int k = 0; k < crossing.frames; ++k) {
        const double d =
            std::remainder(k * crossing.step_mm - place_mm, crossing.frames * crossing.step_mm);
        if (std::abs(d) > 6 * crossing.sigma_mm) continue;
        const double light = crossing.pictures[static_cast<std::size_t>(k)][pixel];
        sum += light;
        first += light * d;
    }
    return {first / sum, sum};
}

void judge_pixels(const Crossing& crossing, SpeckleResult& result, Sums& spacetime, Sums& centred,
                  Sums& moments, Sums& squares, int& claimed) {
    PulseMap map = pulses_of(crossing);
    for (Pulse& pulse : map.pulses) {
        pulse.s = static_cast<double>(pulse.t_ns) / kPeriod * crossing.step_mm;
        pulse.ds_dt = crossing.step_mm / (1e-9 * kPeriod);
    }
    struct Passage {
        double error_mm, light;
    };
    std::vector<const Pulse*> chosen(crossing.pictures.front().size(), nullptr);
    std::vector<Passage> passages(chosen.size());
    const double way_mm = crossing.frames * crossing.step_mm;
    for (int y = 0; y < crossing.rows; ++y)
        for (int x = 0; x < crossing.columns; ++x) {
            const std::size_t pixel = static_cast<std::size_t>(y * crossing.columns + x);
            const double place_mm = (x + 0.5) * crossing.pixel_mm;
            const Moment moment = moment_over_time(crossing, pixel, place_mm);
            ++result.pixels;
            moments.add(moment.at_mm, moment.light);
            squares.add(moment.at_mm, moment.light * moment.light);
            // The passage that lies well within the frames.
            const double passage_mm = place_mm < way_mm / 4 ? place_mm + way_mm : place_mm;
            const Pulse* strongest = nullptr;
            for (const Pulse& pulse : map.cell(x, y)) {
                if (std::abs(pulse.s - passage_mm) > 4 * crossing.sigma_mm) continue;
                if (!strongest || pulse.amplitude > strongest->amplitude) strongest = &pulse;
            }
            if (!strongest) continue;
            ++claimed;
            chosen[pixel] = strongest;
            passages[pixel] = {strongest->s - passage_mm, moment.light};
        }
    const double footprint_px = kFootprintRhos * result.rho_mm / crossing.pixel_mm;
    if (const auto found = estimate_footprint(chosen, crossing.columns, crossing.rows))
        result.footprint_rhos.push_back(found->sigma_px * crossing.pixel_mm / result.rho_mm);
    const auto centres = centres_of_light(chosen, crossing.columns, crossing.rows, footprint_px);
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        if (!chosen[i]) continue;
        const auto& [error_mm, light] = passages[i];
        spacetime.add(error_mm, light);
        const double shift_mm = static_cast<double>(centres[i].shift_px.x()) * crossing.pixel_mm;
        centred.add(error_mm - shift_mm, light);
    }
}

void judge_rows(const Crossing& crossing, Sums& spatial) {
    const double way_mm = crossing.frames * crossing.step_mm;
    for (int k = 0; k < crossing.frames; ++k)
        for (int y = 0; y < crossing.rows; ++y) {
            double sum = 0, first = 0;
            for (int x = 0; x < crossing.columns; ++x) {
                const double d =
                    std::remainder((x + 0.5) * crossing.pixel_mm - k * crossing.step_mm, way_mm);
                if (std::abs(d) > 5 * crossing.sigma_mm) continue;
                const double light =
                    crossing.pictures[static_cast<std::size_t>(k)]
                                     [static_cast<std::size_t>(y * crossing.columns + x)];
                sum += light;
                first += light * d;
            }
            spatial.add(first / sum, sum);
        }
}

}  // namespace

SpeckleResult run(SpeckleTrials trials) {
    // The pulse and its dark surroundings on both sides, and room for the picture of a point.
    const double rho_mm = trials.view.wavelength_nm * 1e-6 / (2 * trials.view.sin_u);
    const double need_mm = 20 * trials.line.sigma_mm + 24 * rho_mm;
    trials.view.columns = static_cast<int>(
        std::bit_ceil(static_cast<unsigned>(std::ceil(need_mm / trials.view.pixel_mm))));
    SpeckleResult result;
    Sums spacetime, centred, moments, squares, spatial, even;
    int claimed = 0;
    double mean = 0;
    for (int i = 0; i < trials.surfaces; ++i) {
        const CoherentSurface surface(trials.view, trials.seed + static_cast<std::uint64_t>(i));
        result.rho_mm = surface.rho_mm();
        for (double light : surface.pixels_of(surface.evenly_lit())) {
            even.add(light - 1, 1);
            mean += light - 1;
        }
        const Crossing crossing = cross(surface, trials);
        judge_pixels(crossing, result, spacetime, centred, moments, squares, claimed);
        judge_rows(crossing, spatial);
    }
    mean /= even.count;
    result.contrast = std::sqrt(even.squares / even.count - mean * mean) / (1 + mean);
    result.dorsch_mm = result.contrast * result.rho_mm / std::numbers::pi;
    result.claimed = static_cast<double>(claimed) / result.pixels;
    result.spacetime = spacetime.root();
    result.centred = centred.root();
    result.moments = moments.root();
    result.moments_by_square_mm = squares.root().weighted_mm;
    result.spatial = spatial.root();
    return result;
}

namespace {

/// |2 J1(v) / v|^2 at v = pi r.
double airy(double r) {
    const double v = std::numbers::pi * r;
    if (v < 1e-6) return 1;
    const double amplitude = 2 * std::cyl_bessel_j(1.0, v) / v;
    return amplitude * amplitude;
}

}  // namespace

double point_moment_by_square(double sigma_rhos) {
    constexpr double kStep = 0.1;  // rho: a tenth of what p changes over
    constexpr int kReach = 500, kAlong = 1200;
    std::vector<double> p(kReach + 1);
    for (int i = 0; i <= kReach; ++i)
        for (int j = 0; j < kAlong; ++j)
            p[static_cast<std::size_t>(i)] += airy(std::hypot(i * kStep, (j + 0.5) * 0.05)) * 0.1;
    double moment = 0, overlap = 0, light = 0;
    for (int i = -kReach; i <= kReach; ++i) {
        const double pi = p[static_cast<std::size_t>(std::abs(i))];
        light += pi;
        for (int k = -kReach; k <= kReach; ++k) {
            const double u = (i - k) * kStep, middle = (i + k) * kStep / 2;
            const double both = pi * p[static_cast<std::size_t>(std::abs(k))] *
                                std::exp(-u * u / (4 * sigma_rhos * sigma_rhos));
            moment += both * middle * middle;
            overlap += both;
        }
    }
    return std::sqrt(moment / (light * light + overlap));
}

RowSpeckle row_speckle(double rho_mm, double height_mm) {
    constexpr int kHeights = 40, kLengths = 800;
    const double reach = 20;  // rho; beyond lies less than 1 part in 1000
    double variance = 0, area = 0;
    for (int j = 0; j < kHeights; ++j) {
        const double y = (j + 0.5) / kHeights;
        const double share = 2 * (1 - y) / kHeights;
        variance += share * airy(y * height_mm / rho_mm);
        for (int i = 0; i < kLengths; ++i)
            area += share * 2 * reach / kLengths *
                    airy(std::hypot((i + 0.5) / kLengths * reach, y * height_mm / rho_mm));
    }
    return {std::sqrt(variance), area / variance * rho_mm};
}

}  // namespace stria
