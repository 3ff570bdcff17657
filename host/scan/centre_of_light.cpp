#include "host/scan/centre_of_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "host/geometry/parallel.h"

namespace stria {
namespace {

constexpr std::uint16_t kDoubtful =
    kPulseOverlapping | kPulseGhostSuspected | kPulseWidthOutOfRange | kPulseTouchesSequenceEnd;

constexpr float kPixelAlonePx =
    0.288675F;  ///< standard deviation of a pixel's square: 1 / sqrt(12)

/// A cell's pulse reduced to what the gradients need.
struct Light {
    double s = 0;
    double width_s = 0;   ///< in units of s; 0: no pulse to compare with
    float log_light = 0;  ///< ln(amplitude x width)
    float sigma_log = 0;  ///< its standard deviation, by the noise
    float sigma_s = 0;
    std::uint16_t source = 0;  ///< laser and exposure
    bool is_doubtful = false;  ///< a pulse with warnings: nothing to compare with
};

Light light_of(const Pulse* pulse) {
    if (!pulse) return {};
    if ((pulse->flags & kDoubtful) != 0 || !(pulse->amplitude > 0) || !(pulse->width > 0)) {
        Light doubtful;
        doubtful.is_doubtful = true;
        return doubtful;
    }
    // The logarithm of a fitted Gaussian's amplitude x width scatters by sqrt(3) / 2 of sigma /
    // width where the background is known and by somewhat more where it is not (the Fisher matrix
    // of Hagen, Kupinski and Dereniak, Appl. Opt. 46, 2007): by about sigma / width.
    const float relative = pulse->sigma / pulse->width;
    const double per_ns = 1e-9 * std::abs(pulse->ds_dt);
    return {pulse->s,
            static_cast<double>(pulse->width) * per_ns,
            std::log(pulse->amplitude * pulse->width),
            relative,
            static_cast<float>(static_cast<double>(pulse->sigma) * per_ns),
            static_cast<std::uint16_t>(pulse->laser_id << 8 | pulse->exposure_index),
            false};
}

bool is_near(const Light& a, const Light& b) {
    return std::abs(a.s - b.s) <= 2 * std::max(a.width_s, b.width_s);
}

bool continues(const Light& a, const Light& b) {
    return a.width_s > 0 && b.width_s > 0 && a.source == b.source && is_near(a, b);
}

struct Slope {
    float value = 0;  ///< d ln E, per px
    float sigma = 0;
};

/// How far the middle of a partly lit pixel's light lies from its own along an axis.
struct BorderShift {
    float px = 0, sigma_px = 0;
};

/// The lights of the map with what lies about them along an axis.
class LightMap {
  public:
    LightMap(std::span<const Pulse* const> chosen, int width, int height)
        : lights_(chosen.size()), size_{width, height} {
        parallel_for_blocks(chosen.size(), 16384, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) lights_[i] = light_of(chosen[i]);
        });
    }

    const Light& at(int x, int y) const {
        return lights_[static_cast<std::size_t>(y) * static_cast<std::size_t>(size_[0]) +
                       static_cast<std::size_t>(x)];
    }

    /// The light `steps` pixels on along the axis (0: u, 1: v); nullptr outside.
    const Light* along(int x, int y, int axis, int steps) const {
        (axis == 0 ? x : y) += steps;
        return x >= 0 && y >= 0 && x < size_[0] && y < size_[1] ? &at(x, y) : nullptr;
    }

    /// How many neighbours in a row continue the surface, 0 to `most`.
    int reach(int x, int y, int axis, int direction, int most) const {
        const Light* here = &at(x, y);
        for (int k = 1; k <= most; ++k) {
            const Light* next = along(x, y, axis, k * direction);
            if (!next || !continues(*here, *next)) return k - 1;
            here = next;
        }
        return most;
    }

    Slope slope(int x, int y, int axis) const {
        const int after = reach(x, y, axis, 1, 2), before = reach(x, y, axis, -1, 2);
        const auto log_at = [&](int k) { return along(x, y, axis, k)->log_light; };
        const auto sigma_at = [&](int k) { return along(x, y, axis, k)->sigma_log; };
        if (after == 2 && before == 2)
            return {(8 * (log_at(1) - log_at(-1)) - (log_at(2) - log_at(-2))) / 12,
                    std::hypot(8 * std::hypot(sigma_at(1), sigma_at(-1)),
                               std::hypot(sigma_at(2), sigma_at(-2))) /
                        12};
        if (after == 0 && before == 0) return {};
        const int from = before > 0 ? -1 : 0, to = after > 0 ? 1 : 0;
        const auto pixels = static_cast<float>(to - from);
        return {(log_at(to) - log_at(from)) / pixels,
                std::hypot(sigma_at(to), sigma_at(from)) / pixels};
    }

    /// Empty where the surface goes on to both sides or to none, or the pixel is as bright as the
    /// ones inwards lead to expect.
    std::optional<BorderShift> border(int x, int y, int axis, float footprint_px) const {
        for (const int inwards : {-1, 1}) {
            if (!ends(x, y, axis, -inwards)) continue;
            const int known = reach(x, y, axis, inwards, 4);
            if (known == 0) return std::nullopt;
            const auto inner = [&](int k) -> const Light& {
                return *along(x, y, axis, k * inwards);
            };
            float expected = inner(1).log_light;
            float sigma = std::hypot(at(x, y).sigma_log, inner(1).sigma_log);
            if (known > 1) {  // as the surface's shading goes on, give or take its texture
                const auto step = [&](int k) {
                    return inner(k).log_light - inner(k + 1).log_light;
                };
                float squares = 0;
                for (int k = 1; k < known; ++k) squares += step(k) * step(k);
                expected += std::clamp(step(1), kSteepestShading, 0.0F);
                sigma = std::hypot(sigma, std::hypot(inner(1).sigma_log, inner(2).sigma_log),
                                   std::sqrt(squares / static_cast<float>(known - 1)));
            }
            const float lit = std::exp(at(x, y).log_light - expected);
            if (1 - lit <= kDarker * lit * sigma) return std::nullopt;
            const float per_share = std::sqrt(3.0F) * footprint_px;
            const float shift = per_share * (1 - lit);
            return BorderShift{static_cast<float>(inwards) * shift,
                               std::hypot(per_share * lit * sigma, kShapeUnknown * shift)};
        }
        return std::nullopt;
    }

  private:
    static constexpr float kSteepestShading = -0.36F;  ///< ln 0.7, a pixel
    static constexpr float kDarker = 3;                ///< standard deviations
    static constexpr float kShapeUnknown = 0.25F;      ///< of the shift

    /// Whether the surface seen here does not go on in the next two pixels.
    bool ends(int x, int y, int axis, int direction) const {
        for (const int k : {1, 2}) {
            const Light* next = along(x, y, axis, k * direction);
            if (!next) return k == 2;
            if (next->is_doubtful || (next->width_s > 0 && is_near(at(x, y), *next))) return false;
        }
        return true;
    }

    std::vector<Light> lights_;
    std::array<int, 2> size_;
};

/// Sums over places of the bends of s found and those that texture draws per px^2 of footprint.
struct BendSums {
    std::size_t count = 0;
    double products = 0, squares = 0;  ///< found x drawn, drawn^2; both over the noise

    void add(const BendSums& other) {
        count += other.count;
        products += other.products;
        squares += other.squares;
    }
    double slope() const { return products / squares; }
};

/// The places of a row, along an axis, whose neighbourhood is whole and where texture bends.
BendSums bends_of_row(const LightMap& map, int width, int y, int axis) {
    // The five-point slope of ln E less the mean of those 3 px to either side, by the differences
    // L(k) - L(-k), k = 1 to 5. A second difference of neighbours would ask most of the finest
    // texture, whose slopes the differences between pixels understate.
    constexpr std::array<double, 5> kBend{7.5 / 12, 3.0 / 12, 0, -4.0 / 12, 0.5 / 12};
    constexpr double kTextured = 0.1, kOverNoise = 5;
    constexpr double kLargestPx = 3;  // what no footprint bends: an edge between surfaces
    BendSums sums;
    for (int x = 0; x < width; ++x) {
        if (map.reach(x, y, axis, 1, 5) < 5 || map.reach(x, y, axis, -1, 5) < 5) continue;
        const auto light = [&](int k) -> const Light& { return *map.along(x, y, axis, k); };
        double texture = 0, variance = 0;
        for (int k = 1; k <= 5; ++k) {
            const double by = kBend[static_cast<std::size_t>(k - 1)];
            texture += by * static_cast<double>(light(k).log_light - light(-k).log_light);
            variance += by * by *
                        static_cast<double>(light(k).sigma_log * light(k).sigma_log +
                                            light(-k).sigma_log * light(-k).sigma_log);
        }
        if (std::abs(texture) < std::max(kTextured, kOverNoise * std::sqrt(variance))) continue;
        const double noise = std::hypot(static_cast<double>(light(0).sigma_s),
                                        static_cast<double>(light(-3).sigma_s) / 2,
                                        static_cast<double>(light(3).sigma_s) / 2);
        const double pitch = (light(5).s - light(-5).s) / 10;
        const double bend = light(0).s - (light(-3).s + light(3).s) / 2;
        if (!(noise > 0) || std::abs(bend) > kLargestPx * std::abs(pitch)) continue;
        const double drawn = pitch * texture;
        sums.add({1, bend * drawn / (noise * noise), drawn * drawn / (noise * noise)});
    }
    return sums;
}

CentreOfLight centre_at(const LightMap& map, int x, int y, float footprint_px) {
    const float seen_px = footprint_px > 0 ? footprint_px : kPixelAlonePx;
    CentreOfLight centre;
    int borders = 0;
    for (int axis = 0; axis < 2; ++axis) {
        if (const auto border = map.border(x, y, axis, seen_px)) {
            centre.shift_px[axis] = border->px;
            centre.sigma_px[axis] = border->sigma_px;
            ++borders;
        } else if (footprint_px > 0) {
            const Slope slope = map.slope(x, y, axis);
            centre.shift_px[axis] = footprint_px * footprint_px * slope.value;
            centre.sigma_px[axis] = footprint_px * footprint_px * slope.sigma;
        }
    }
    centre.is_partly_lit = borders > 0;
    if (borders == 2) centre.shift_px *= std::sqrt(0.5F);  // a border across the corner
    const float longest = 2 * seen_px;
    if (const float length = centre.shift_px.norm(); length > longest)
        centre.shift_px *= longest / length;
    return centre;
}

}  // namespace

std::vector<CentreOfLight> centres_of_light(std::span<const Pulse* const> chosen, int width,
                                            int height, double footprint_px) {
    const LightMap map(chosen, width, height);
    std::vector<CentreOfLight> centres(chosen.size());
    parallel_for_blocks(
        static_cast<std::size_t>(height), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t row = begin; row < end; ++row)
                for (int x = 0; x < width; ++x) {
                    const int y = static_cast<int>(row);
                    if (!(map.at(x, y).width_s > 0)) continue;
                    centres[row * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] =
                        centre_at(map, x, y, static_cast<float>(footprint_px));
                }
        });
    return centres;
}

std::optional<PixelFootprint> estimate_footprint(std::span<const Pulse* const> chosen, int width,
                                                 int height) {
    constexpr int kBands = 8;
    constexpr std::size_t kFewest = 1000;
    constexpr double kCertain = 4, kSmallestPx = 0.2, kLargestPx = 3;
    const LightMap map(chosen, width, height);
    std::array<BendSums, kBands> bands;
    parallel_for_blocks(kBands, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t band = begin; band < end; ++band)
            for (int y = static_cast<int>(band) * height / kBands;
                 y < (static_cast<int>(band) + 1) * height / kBands; ++y)
                for (int axis = 0; axis < 2; ++axis)
                    bands[band].add(bends_of_row(map, width, y, axis));
    });
    BendSums all;
    for (const BendSums& band : bands) all.add(band);
    if (all.count < kFewest) return std::nullopt;
    const double variance = all.slope();
    double squares = 0;  // what each band's texture would have it otherwise
    for (const BendSums& band : bands)
        squares += std::pow(band.products - variance * band.squares, 2);
    const double sigma = std::sqrt(squares) / all.squares;
    if (!(variance > kCertain * sigma)) return std::nullopt;
    const double footprint = std::sqrt(variance);
    if (footprint < kSmallestPx || footprint > kLargestPx) return std::nullopt;
    return PixelFootprint{footprint, sigma / (2 * footprint)};
}

}  // namespace stria
