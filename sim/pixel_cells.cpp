#include "sim/pixel_cells.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace stria {
namespace {

constexpr int kDarkRounds = 3;  ///< the same where there is but ambient light
constexpr double kStep = 0.1;   ///< cell lengths times the root of the area: for a slope
constexpr int kRounds = 5;      ///< of looking along a side, each at three places: two bits more
constexpr double kJump = 1.0;  ///< beam widths between corners of a cell that no smooth slope makes
constexpr double kFlat = 0.03;  ///< beam widths that the middle may lie off the corners' mean
constexpr int kDeepest = 3;     ///< times a cell is cut in four
constexpr double kNoArea = 1e-7;
constexpr double kAside = 0.06;  ///< cell lengths beside a straight border, where kinds must differ

/// Whether a border that shows by itself lies between two samples: of light, of an object.
bool is_border(const RayLight& a, const RayLight& b) {
    if (differs(a.ambient, b.ambient, kAmbientStep)) return true;
    if ((a.rate > 0) != (b.rate > 0)) return true;
    return a.rate > 0 && a.object != b.object;
}

/// What a slope may do as well; a border where the cell is as small as cells get.
bool is_steep(const RayLight& a, const RayLight& b, double sigmas) {
    if (a.rate <= 0 || b.rate <= 0) return false;
    return differs(a.rate, b.rate, kRateStep) ||
           std::abs(a.position - b.position) * static_cast<double>(a.per_position) > sigmas;
}

/// Weighted mean; where some are dark, the sheet's place is that of the others.
class MeanSample {
  public:
    void add(const PixelSample& s, float weight) {
        if (all_ == 0) mean_ = s;
        if (lit_ == 0 && s.light.rate > 0) mean_ = s;
        all_ += weight;
        ambient_ += weight * s.light.ambient;
        if (s.light.rate <= 0) return;
        lit_ += weight;
        const double w = static_cast<double>(weight);
        position_ += w * s.light.position;
        per_s_ += weight * s.light.per_s;
        rate_ += weight * s.light.rate * s.light.speckle;
        inside_ += weight * s.shape.inside;
        shift_ += weight * s.shape.shift;
        spread_ += weight * s.shape.spread;
    }
    PixelSample value() const {
        PixelSample mean = mean_;
        mean.light.ambient = ambient_ / all_;
        mean.light.rate = rate_ / all_;
        mean.light.speckle = 1;
        if (lit_ == 0) return mean;
        mean.light.position = position_ / static_cast<double>(lit_);
        mean.light.per_s = per_s_ / lit_;
        mean.shape.inside = inside_ / lit_;
        mean.shape.shift = shift_ / lit_;
        mean.shape.spread = spread_ / lit_;
        return mean;
    }

  private:
    PixelSample mean_;
    float all_ = 0, lit_ = 0, ambient_ = 0, per_s_ = 0, rate_ = 0, inside_ = 0, shift_ = 0,
          spread_ = 0;
    double position_ = 0;
};

/// A square of the pixel: its corners in the order of its outline. Whole numbers count the sides
/// of the smallest cells.
struct Cell {
    int x = 0, y = 0, size = 0;
    std::array<PixelSample, 4> corners;
    PixelSample middle;

    static Eigen::Vector2d corner_at(std::size_t k) { return {k == 1 || k == 2, k >= 2}; }
};

bool is_lit(const Cell& cell) {
    return std::any_of(cell.corners.begin(), cell.corners.end(),
                       [](const PixelSample& s) { return s.light.rate > 0; });
}

/// A side that a border crosses, from its end with the lower coordinates.
struct Side {
    int x = 0, y = 0, size = 0;
    bool along_u = true;
    const PixelSample *first = nullptr, *last = nullptr;
    double low = 0, high = 1;  ///< of the border, in side lengths
    bool is_same(const Side& other) const {
        return x == other.x && y == other.y && size == other.size && along_u == other.along_u;
    }
};

constexpr std::size_t kLooks = 8;  ///< rays for a parted cell

/// How far beside a part's centroid its slope is looked for, cell lengths.
double slope_step(double area) { return kStep * std::sqrt(std::max(area, 1e-4)); }

/// How a border parts a cell: what is like the first corner, and what is not.
struct Parting {
    std::array<bool, 4> other{};
    std::array<std::size_t, 4> sides{};  ///< index, of the sides between unlike corners
    std::array<double, 2> areas{};       ///< shares of the cell
    std::array<Eigen::Vector2d, 2> centroids = {Eigen::Vector2d(0.5, 0.5),
                                                Eigen::Vector2d(0.5, 0.5)};
    std::array<Eigen::Matrix2d, 2> covariances;  ///< of places in the parts, cell lengths squared
    std::array<Eigen::Vector2d, 2> aside;        ///< of the border's middle, where it is one line
    bool is_one_line = false;
};

class PixelCutter {
  public:
    PixelCutter(const PixelCaster& cast, const PixelSampling& sampling,
                std::vector<PixelPart>& parts)
        : cast_(cast), sampling_(sampling), units_(sampling.cells << kDeepest), parts_(parts) {}
    void run();

  private:
    Eigen::Vector2d place(double x, double y) const { return {x / units_ - 0.5, y / units_ - 0.5}; }
    Eigen::Vector2d place(const Cell& cell, const Eigen::Vector2d& inside) const {
        return place(cell.x + inside.x() * cell.size, cell.y + inside.y() * cell.size);
    }
    bool is_last() const { return depth_ == kDeepest; }
    bool is_apart(const RayLight& a, const RayLight& b) const {
        return is_border(a, b) || (is_last() && is_steep(a, b, kJump));
    }
    void look(std::span<const Eigen::Vector2d> places, std::vector<PixelSample>& samples) const {
        samples.assign(places.size(), {});
        if (!places.empty()) cast_(places, samples);
    }
    void first_cells();
    bool is_uneven(const Cell& cell) const;
    bool is_crossed(const Cell& cell) const;
    void add_even(const Cell& cell);
    Parting begin_parting(const Cell& cell, std::vector<Side>& sides) const;
    void find_crossings(std::vector<Side>& sides) const;
    void finish_parting(Parting& parting, const std::vector<Side>& sides) const;
    Eigen::Vector2d slope_of(const Parting& parting, std::size_t kind,
                             const PixelSample* seen) const;
    bool add_crossed(const Cell& cell, const Parting& parting, const PixelSample* seen);
    void part_cells(const std::vector<const Cell*>& crossed, std::vector<const Cell*>& to_split);
    void split(const std::vector<const Cell*>& cells);

    const PixelCaster& cast_;
    const PixelSampling& sampling_;
    int units_;
    int depth_ = 0;
    std::vector<PixelPart>& parts_;
    std::vector<Cell> cells_, next_;
};

void PixelCutter::first_cells() {
    const int n = sampling_.cells, size = 1 << kDeepest;
    std::vector<Eigen::Vector2d> places;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) places.push_back(place(i * size, j * size));
    std::vector<PixelSample> nodes, middles;
    look(places, nodes);
    places.clear();
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const PixelSample* const at = &nodes[static_cast<std::size_t>(j * (n + 1) + i)];
            cells_.push_back({i * size, j * size, size, {at[0], at[1], at[n + 2], at[n + 1]}, {}});
            // Where nothing is lit there is nothing to refine.
            if (is_lit(cells_.back())) places.push_back(place((i + 0.5) * size, (j + 0.5) * size));
        }
    look(places, middles);
    auto middle = middles.begin();
    for (Cell& cell : cells_) cell.middle = is_lit(cell) ? *middle++ : cell.corners[0];
}

/// Whether slope, bend or rate ask for smaller cells.
bool PixelCutter::is_uneven(const Cell& cell) const {
    MeanSample corners;
    const RayLight& middle = cell.middle.light;
    for (const PixelSample& corner : cell.corners) {
        corners.add(corner, 1);
        for (const PixelSample& other : cell.corners)
            if (!is_border(corner.light, other.light) &&
                is_steep(corner.light, other.light, 2 * sampling_.part_sigmas))
                return true;
        if (!is_border(corner.light, middle) &&
            is_steep(corner.light, middle, 2 * sampling_.part_sigmas))
            return true;
    }
    if (is_crossed(cell) || middle.rate <= 0) return false;
    const double off = corners.value().light.position - middle.position;
    return std::abs(off) * static_cast<double>(middle.per_position) > kFlat;
}

bool PixelCutter::is_crossed(const Cell& cell) const {
    return std::any_of(cell.corners.begin() + 1, cell.corners.end(), [&](const PixelSample& s) {
        return is_apart(cell.corners[0].light, s.light);
    });
}

void PixelCutter::add_even(const Cell& cell) {
    // Simpson's rule in the plane: exact for what bends evenly.
    MeanSample sample;
    for (const PixelSample& corner : cell.corners) sample.add(corner, 1);
    sample.add(cell.middle, 8);
    const auto at = [&](std::size_t k) { return cell.corners[k].light.position; };
    const double size = static_cast<double>(cell.size) / units_;
    PixelPart part{sample.value(), size * size, 0};
    if (cell.middle.light.rate > 0 && std::all_of(cell.corners.begin(), cell.corners.end(),
                                                  [](auto& s) { return s.light.rate > 0; })) {
        const double per = static_cast<double>(cell.middle.light.per_position);
        const double u = (at(1) - at(0) + at(2) - at(3)) / 2 * per;
        const double v = (at(3) - at(0) + at(2) - at(1)) / 2 * per;
        part.footprint2 = (u * u + v * v) / 12;
    }
    parts_.push_back(part);
}

Parting PixelCutter::begin_parting(const Cell& cell, std::vector<Side>& sides) const {
    Parting parting;
    for (std::size_t k = 1; k < 4; ++k)
        parting.other[k] = is_apart(cell.corners[0].light, cell.corners[k].light);
    for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t next = (k + 1) % 4;
        if (parting.other[k] == parting.other[next]) continue;
        const std::size_t first = k >= 2 ? next : k, last = k >= 2 ? k : next;
        const Side side{cell.x + (first == 1 ? cell.size : 0),
                        cell.y + (first == 3 ? cell.size : 0),
                        cell.size,
                        k % 2 == 0,
                        &cell.corners[first],
                        &cell.corners[last]};
        const auto known = std::find_if(sides.begin(), sides.end(),
                                        [&](const Side& other) { return side.is_same(other); });
        parting.sides[k] = static_cast<std::size_t>(known - sides.begin());
        if (known == sides.end()) sides.push_back(side);
    }
    return parting;
}

/// All sides at once, so that rays travel in packets.
void PixelCutter::find_crossings(std::vector<Side>& sides) const {
    std::vector<Eigen::Vector2d> places;
    std::vector<PixelSample> seen;
    const bool dark = std::none_of(sides.begin(), sides.end(), [](const Side& side) {
        return side.first->light.rate > 0 || side.last->light.rate > 0;
    });
    for (int round = 0; round < (dark ? kDarkRounds : kRounds); ++round) {
        places.clear();
        for (const Side& side : sides)
            for (int k = 1; k <= 3; ++k) {
                const double t = side.size * (side.low + (side.high - side.low) * k / 4);
                places.push_back(
                    place(side.x + (side.along_u ? t : 0), side.y + (side.along_u ? 0 : t)));
            }
        look(places, seen);
        const PixelSample* sample = seen.data();
        for (Side& side : sides) {
            int alike = 0;
            while (alike < 3 && !is_apart(side.first->light, sample[alike].light)) ++alike;
            const double quarter = (side.high - side.low) / 4;
            side.low += alike * quarter;
            side.high = side.low + quarter;
            sample += 3;
        }
    }
}

void PixelCutter::finish_parting(Parting& parting, const std::vector<Side>& sides) const {
    // Outline of what is unlike the first corner, in cell lengths.
    std::array<Eigen::Vector2d, 8> outline;
    std::array<Eigen::Vector2d, 4> crossings;
    std::size_t count = 0, crossed = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t next = (k + 1) % 4;
        if (parting.other[k]) outline[count++] = Cell::corner_at(k);
        if (parting.other[k] == parting.other[next]) continue;
        const Side& side = sides[parting.sides[k]];
        const double t = (side.low + side.high) / 2;
        const Eigen::Vector2d from = Cell::corner_at(k >= 2 ? next : k);
        const Eigen::Vector2d to = Cell::corner_at(k >= 2 ? k : next);
        outline[count++] = crossings[crossed++] = from + t * (to - from);
    }
    double area = 0;
    Eigen::Vector2d moment = Eigen::Vector2d::Zero();
    Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
    for (std::size_t k = 0; k < count; ++k) {
        const Eigen::Vector2d &a = outline[k], &b = outline[(k + 1) % count];
        const double cross = a.x() * b.y() - a.y() * b.x();
        area += cross / 2;
        moment += cross / 6 * (a + b);
        second +=
            cross / 24 * (a * a.transpose() + b * b.transpose() + (a + b) * (a + b).transpose());
    }
    // The first kind has what the square has and the other has not.
    parting.areas = {1 - area, area};
    const std::array<Eigen::Vector2d, 2> moments = {Eigen::Vector2d::Constant(0.5) - moment,
                                                    moment};
    Eigen::Matrix2d square;
    square << 1.0 / 3, 0.25, 0.25, 1.0 / 3;
    const std::array<Eigen::Matrix2d, 2> seconds = {square - second, second};
    for (std::size_t kind = 0; kind < 2; ++kind) {
        if (parting.areas[kind] <= kNoArea) continue;
        const Eigen::Vector2d at = moments[kind] / parting.areas[kind];
        parting.centroids[kind] = at;
        parting.covariances[kind] = seconds[kind] / parting.areas[kind] - at * at.transpose();
    }
    parting.is_one_line = crossed == 2;
    if (!parting.is_one_line) return;
    const Eigen::Vector2d middle = (crossings[0] + crossings[1]) / 2;
    const Eigen::Vector2d along = crossings[1] - crossings[0];
    Eigen::Vector2d aside = kAside * Eigen::Vector2d(-along.y(), along.x()).normalized();
    if (aside.dot(parting.centroids[1] - parting.centroids[0]) < 0) aside = -aside;
    parting.aside = {middle - aside, middle + aside};
}

/// Of the sheet's place about a part's centroid, beam widths a cell length.
Eigen::Vector2d PixelCutter::slope_of(const Parting& parting, std::size_t kind,
                                      const PixelSample* seen) const {
    const RayLight& here = seen[kind].light;
    Eigen::Vector2d slope = Eigen::Vector2d::Zero();
    if (here.rate <= 0) return slope;
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const RayLight& beside = seen[4 + 2 * axis + kind].light;
        if (!is_border(here, beside))
            slope[static_cast<Eigen::Index>(axis)] =
                (beside.position - here.position) / slope_step(parting.areas[kind]);
    }
    return slope * static_cast<double>(here.per_position);
}

/// False: the border is not what it was taken for, and smaller cells may tell.
bool PixelCutter::add_crossed(const Cell& cell, const Parting& parting, const PixelSample* seen) {
    std::array<MeanSample, 2> values;
    std::array<double, 2> footprints{};
    for (std::size_t kind = 0; kind < 2; ++kind) {
        if (parting.areas[kind] <= kNoArea) continue;
        bool is_of_its_kind = true;
        MeanSample mean;
        for (std::size_t k = 0; k < 4; ++k) {
            if (parting.other[k] != (kind == 1)) continue;
            mean.add(cell.corners[k], 1);
            is_of_its_kind = is_of_its_kind && !is_apart(seen[kind].light, cell.corners[k].light);
            // A sliver's border is checked by its centroid alone.
            if (parting.is_one_line && parting.areas[kind] > 2 * kAside)
                is_of_its_kind =
                    is_of_its_kind && !is_apart(seen[2 + kind].light, cell.corners[k].light);
        }
        if (!is_of_its_kind && !is_last()) return false;
        values[kind] = mean;
        if (!is_of_its_kind) continue;
        values[kind] = {};
        values[kind].add(seen[kind], 1);
        const Eigen::Vector2d slope = slope_of(parting, kind, seen);
        footprints[kind] = slope.dot(parting.covariances[kind] * slope);
    }
    const double size = static_cast<double>(cell.size) / units_;
    for (std::size_t kind = 0; kind < 2; ++kind)
        if (parting.areas[kind] > kNoArea)
            parts_.push_back(
                {values[kind].value(), parting.areas[kind] * size * size, footprints[kind]});
    return true;
}

void PixelCutter::part_cells(const std::vector<const Cell*>& crossed,
                             std::vector<const Cell*>& to_split) {
    std::vector<Side> sides;
    std::vector<Parting> partings;
    for (const Cell* cell : crossed) partings.push_back(begin_parting(*cell, sides));
    find_crossings(sides);
    std::vector<Eigen::Vector2d> places;
    for (std::size_t i = 0; i < crossed.size(); ++i) {
        Parting& parting = partings[i];
        finish_parting(parting, sides);
        for (const Eigen::Vector2d& inside : parting.centroids)
            places.push_back(place(*crossed[i], inside));
        for (std::size_t k = 0; k < 2; ++k)
            places.push_back(parting.is_one_line ? place(*crossed[i], parting.aside[k])
                                                 : places[places.size() - 2]);
        for (int axis = 0; axis < 2; ++axis)
            for (std::size_t k = 0; k < 2; ++k)
                places.push_back(
                    place(*crossed[i], parting.centroids[k] + slope_step(parting.areas[k]) *
                                                                  Eigen::Vector2d::Unit(axis)));
    }
    std::vector<PixelSample> seen;
    look(places, seen);
    for (std::size_t i = 0; i < crossed.size(); ++i)
        if (!add_crossed(*crossed[i], partings[i], &seen[kLooks * i]))
            to_split.push_back(crossed[i]);
}

void PixelCutter::split(const std::vector<const Cell*>& cells) {
    // Middles of the sides, then of the quarters.
    std::vector<Eigen::Vector2d> places;
    for (const Cell* cell : cells) {
        for (std::size_t k = 0; k < 4; ++k)
            places.push_back(place(*cell, (Cell::corner_at(k) + Cell::corner_at((k + 1) % 4)) / 2));
        for (std::size_t k = 0; k < 4; ++k)
            places.push_back(
                place(*cell, (Cell::corner_at(k) + Eigen::Vector2d::Constant(0.5)) / 2));
        places.push_back(place(*cell, Eigen::Vector2d::Constant(0.5)));
    }
    std::vector<PixelSample> samples;
    look(places, samples);
    next_.clear();
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const PixelSample* const at = &samples[9 * i];
        for (std::size_t k = 0; k < 4; ++k) {
            const int half = cells[i]->size / 2;
            const Eigen::Vector2d corner = Cell::corner_at(k);
            Cell quarter{cells[i]->x + half * static_cast<int>(corner.x()),
                         cells[i]->y + half * static_cast<int>(corner.y()),
                         half,
                         {},
                         at[4 + k]};
            quarter.corners[k] = cells[i]->corners[k];
            quarter.corners[(k + 1) % 4] = at[k];
            quarter.corners[(k + 2) % 4] = at[8];
            quarter.corners[(k + 3) % 4] = at[(k + 3) % 4];
            next_.push_back(quarter);
        }
    }
    cells_.swap(next_);
}

void PixelCutter::run() {
    first_cells();
    for (depth_ = 0; !cells_.empty(); ++depth_) {
        std::vector<const Cell*> crossed, to_split;
        for (const Cell& cell : cells_) {
            if (!is_last() && is_uneven(cell))
                to_split.push_back(&cell);
            else if (is_crossed(cell))
                crossed.push_back(&cell);
            else
                add_even(cell);
        }
        if (!crossed.empty()) part_cells(crossed, to_split);
        if (to_split.empty()) return;
        split(to_split);
    }
}

}  // namespace

void cut_pixel(const PixelCaster& cast, const PixelSampling& sampling,
               std::vector<PixelPart>& parts) {
    PixelCutter(cast, sampling, parts).run();
}

}  // namespace stria
