#include "host/scan/range_from_pulses.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "firmware/core/median.h"
#include "host/core/errors.h"
#include "host/geometry/parallel.h"
#include "host/geometry/range_grid.h"
#include "host/scan/judge_pulses.h"
#include "host/scan/light_change.h"
#include "host/scan/systematic.h"

namespace stria {
namespace {

using Candidate = PulseCandidate;

/// Speed of the sheet (mm per unit of s, across itself) over the point that pulse and ray fix.
double sheet_speed(const Channel& channel, const Triangulation& hit, double s) {
    // The point moves with d_point_d_s along its ray while it stays on the sheet; its component
    // across the sheet is how fast the sheet sweeps over a fixed surface point.
    const Rigid3 scan = scan_from_camera(channel, s);
    const Eigen::Vector3d n = scan.rotation * sheet_at(channel, s).normal;
    return std::abs(n.dot(hit.d_point_d_s));
}

/// Spacetime pulses err in time, spatial peaks in place.
bool errs_in_time(const PulseMap& map, const Pulse& pulse) {
    return map.mode == StripeMode::spacetime && (pulse.flags & kPulseSpatialFallback) == 0;
}

/// How the point moves per unit of s that the crossing is misjudged by. A swept pixel stays; on a
/// rail or turntable the point is followed along its image path meanwhile, so that either moves
/// along the camera's ray.
Eigen::Vector3d motion_by_crossing(const Channel& channel, const Triangulation& hit, double s) {
    if (channel.axis.kind == MachineKind::swept) return hit.d_point_d_s;
    const double h = channel.axis.kind == MachineKind::turntable ? 1e-5 : 1e-3;  // rad, mm
    const auto image_at = [&](double at) {
        return project(channel.camera, scan_from_camera(channel, at).inverse() * hit.point_in_scan);
    };
    const auto before = image_at(s - h), after = image_at(s + h);
    if (!before || !after) return hit.d_point_d_s;
    const Eigen::Vector2d path = (*after - *before) / (2 * h);
    return hit.d_point_d_s + path.x() * hit.d_point_d_u + path.y() * hit.d_point_d_v;
}

double expected_width(const PulseMap& map, const Channel& channel, const Pulse& pulse,
                      const Triangulation& hit) {
    const LaserSheet sheet = sheet_at(channel, pulse.s);
    const Eigen::Vector3d in_camera =
        scan_from_camera(channel, pulse.s).inverse() * hit.point_in_scan;
    const double sigma_mm = sigma_at(sheet, in_camera);
    if (errs_in_time(map, pulse))
        return 1e9 * sigma_mm / (sheet_speed(channel, hit, pulse.s) * std::abs(pulse.ds_dt));
    return 0;  // a spatial width depends on the surface's tilt: nothing to compare with
}

bool inside(const ValidVolume& volume, const Eigen::Vector3d& point) {
    return (point.array() >= volume.min.array()).all() &&
           (point.array() <= volume.max.array()).all();
}

constexpr std::uint16_t kDoubtful =
    kPulseOverlapping | kPulseGhostSuspected | kPulseWidthOutOfRange | kPulseTouchesSequenceEnd;

/// Without warnings first, then the strongest.
bool better(const Candidate& a, const Candidate& b) {
    const bool doubt_a = (a.pulse->flags & kDoubtful) != 0;
    const bool doubt_b = (b.pulse->flags & kDoubtful) != 0;
    if (doubt_a != doubt_b) return doubt_b;
    return a.pulse->amplitude > b.pulse->amplitude;
}

/// @param pixel_sigma  of where in its pixel the light came from
RangePoint make_point(const PulseMap& map, const Candidate& candidate, const Channel& channel,
                      const RangeOptions& options,
                      const Eigen::Vector2f& pixel_sigma = Eigen::Vector2f::Zero()) {
    const Pulse& pulse = *candidate.pulse;
    const Triangulation& hit = candidate.hit;
    RangePoint point;
    point.position = hit.point_in_scan;
    point.intensity = pulse.amplitude;
    point.s = pulse.s;
    point.flags = candidate.flags;
    Eigen::Vector3d direction = hit.ray_in_scan;
    double along_mm = 0;
    if (errs_in_time(map, pulse))
        along_mm = motion_by_crossing(channel, hit, pulse.s).norm() *
                   std::abs(pulse.sigma * 1e-9 * pulse.ds_dt);
    else {
        direction = hit.d_point_d_u.normalized();
        if (direction.dot(hit.ray_in_scan) < 0) direction = -direction;
        along_mm = hit.d_point_d_u.norm() * pulse.sigma;
    }
    // A wrong s moves the point by itself, whatever was measured in the images.
    const std::array<Eigen::Vector3d, 3> moves{hit.d_point_d_s * options.axis_sigma_s,
                                               hit.d_point_d_u * double{pixel_sigma.x()},
                                               hit.d_point_d_v * double{pixel_sigma.y()}};
    double along = along_mm * along_mm, across = 0;
    for (const Eigen::Vector3d& move : moves) {
        const double part = move.dot(direction);
        along += part * part;
        across += (move - part * direction).squaredNorm();
    }
    point.sigma_across_mm = static_cast<float>(std::sqrt(across));
    point.error_direction = direction.cast<float>();
    point.sigma_mm = static_cast<float>(std::sqrt(along));
    return point;
}

template <typename Get>
double median_of(const RangeImage& image, Get get) {
    std::vector<double> values;
    for (std::size_t i = 0; i < image.cell_count(); ++i)
        if (image.mask[i]) values.push_back(get(image.points[i]));
    return median(std::move(values));
}

/// Stations spread over the sweep, close enough for linear interpolation to hold.
std::vector<Station> make_stations(const Channel& channel, double from, double to) {
    const double span = to - from;
    int count = 2;
    if (channel.axis.kind == MachineKind::swept) count = 9;
    if (channel.axis.kind == MachineKind::turntable)
        count = 2 + static_cast<int>(std::ceil(span / 0.01));  // 0.01 rad: sagitta 1e-5 of radius
    std::vector<Station> stations;
    for (int i = 0; i < count; ++i) {
        const double s = from + span * i / (count - 1);
        const Rigid3 scan = scan_from_camera(channel, s);
        stations.push_back({s, scan.translation, scan * sheet_at(channel, s).apex});
        if (!(span > 0)) break;
    }
    return stations;
}

void add_systematic(RangeImage& image, const std::vector<Eigen::Vector2f>& pixels,
                    const ScannerModel& model, const Channel& channel, int keep) {
    std::vector<ScanSample> samples;
    const std::size_t stride = std::max<std::size_t>(1, valid_count(image) / 1500);
    std::size_t seen = 0;
    for (std::size_t i = 0; i < image.cell_count(); ++i)
        if (image.mask[i] && seen++ % stride == 0)
            samples.push_back({pixels[i].cast<double>(), image.points[i].s,
                               image.points[i].error_direction.cast<double>()});
    const SystematicErrors errors(model, channel, samples);
    if (errors.mode_count() == 0) return;
    image.sensitivity_count = std::min(keep, errors.mode_count());
    const auto kept = static_cast<std::size_t>(image.sensitivity_count);
    image.sensitivity.assign(image.cell_count() * kept, 0.0F);
    parallel_for_blocks(image.cell_count(), 16384, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!image.mask[i]) continue;
            const Eigen::VectorXd moves =
                errors.displacements(pixels[i].cast<double>(), image.points[i].s);
            image.points[i].sigma_systematic_mm = static_cast<float>(moves.norm());
            for (std::size_t k = 0; k < kept; ++k)
                image.sensitivity[i * kept + k] =
                    static_cast<float>(moves[static_cast<Eigen::Index>(k)]);
        }
    });
}

/// Candidates of every cell, with the counts of what was refused.
std::vector<std::vector<Candidate>> triangulate_all(const PulseMap& map, const ScannerModel& model,
                                                    const RangeOptions& options,
                                                    RangeStatistics& statistics) {
    const std::size_t cells = map.cell_begin.size() - 1;
    constexpr std::size_t kGrain = 8192;
    std::vector<std::vector<Candidate>> found(cells);
    std::vector<RangeStatistics> parts((cells + kGrain - 1) / kGrain);
    parallel_for_blocks(cells, kGrain, [&](std::size_t begin, std::size_t end) {
        RangeStatistics& part = parts[begin / kGrain];
        for (std::size_t i = begin; i < end; ++i) {
            const auto cell =
                std::span(map.pulses)
                    .subspan(map.cell_begin[i], map.cell_begin[i + 1] - map.cell_begin[i]);
            for (const Pulse& pulse : cell) {
                const Channel* channel = find_channel(model, map.camera_id, pulse.laser_id);
                if (!channel) continue;
                const auto hit = triangulate(*channel, {pulse.u, pulse.v}, pulse.s);
                if (!hit) {
                    ++part.no_intersection;
                    continue;
                }
                if (!options.keep_outside_volume && !model.volume.is_empty() &&
                    !inside(model.volume, hit->point_in_scan)) {
                    ++part.outside_volume;
                    continue;
                }
                const double width = expected_width(map, *channel, pulse, *hit);
                found[i].push_back(
                    {&pulse, *hit, width > 0 ? pulse.width / width : 1.0, widths_apart(pulse, cell),
                     pulse.flags,
                     options.directions_compared && (pulse.flags & kPulseGhostSuspected) != 0});
            }
        }
    });
    for (const RangeStatistics& part : parts) {
        statistics.no_intersection += part.no_intersection;
        statistics.outside_volume += part.outside_volume;
    }
    return found;
}

template <typename Get>
double median_over(const std::vector<std::vector<Candidate>>& found, Get get) {
    std::vector<double> values;
    for (const auto& cell : found)
        for (const Candidate& candidate : cell) values.push_back(get(candidate));
    return median(std::move(values), 1.0);
}

/// Marks cells where two pulses run together (judge_pulses.h).
std::vector<Merging> merging_cells(const std::vector<std::vector<Candidate>>& found,
                                   const RangeOptions& options) {
    constexpr double kTwoTogether = 2;  // times the widest; more is light scattered all about
    constexpr double kWider = 1.1, kMisfit = 3, kSoon = 3;
    const double misfit = kMisfit * std::max(1.0, median_over(found, [](const Candidate& c) {
                                                 return static_cast<double>(c.pulse->chi_square);
                                             }));
    std::vector<Merging> merging(found.size(), Merging::no);
    for (std::size_t i = 0; i < found.size(); ++i)
        for (const Candidate& c : found[i]) {
            const double ratio = c.width_ratio;
            if ((c.flags & kPulseOverlapping) != 0 && c.apart > kParted) {
                if (c.apart < kSoon) merging[i] = std::max(merging[i], Merging::soon);
                continue;
            }
            if (ratio > kTwoTogether * options.max_width_ratio || ratio < kWider) continue;
            if (ratio > options.max_width_ratio || c.apart < kParted)
                merging[i] = Merging::surely;
            else if (static_cast<double>(c.pulse->chi_square) > misfit)
                merging[i] = std::max(merging[i], Merging::maybe);
        }
    return merging;
}

/// Moves the chosen candidate of every cell to its centre of light; returns the centres.
std::vector<CentreOfLight> move_to_centres_of_light(std::vector<std::vector<Candidate>>& found,
                                                    const PulseMap& pulses,
                                                    const ScannerModel& model,
                                                    const RangeOptions& options,
                                                    PixelFootprint& footprint) {
    std::vector<const Pulse*> chosen(found.size(), nullptr);
    for (std::size_t i = 0; i < found.size(); ++i)
        if (!found[i].empty()) chosen[i] = found[i].front().pulse;
    footprint =
        options.footprint_px
            ? PixelFootprint{*options.footprint_px, 0}
            : estimate_footprint(chosen, pulses.width, pulses.height).value_or(PixelFootprint{});
    if (options.footprint_px && !(footprint.sigma_px > 0)) return {};
    auto centres = centres_of_light(chosen, pulses.width, pulses.height, footprint.sigma_px);
    parallel_for_blocks(found.size(), 8192, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!chosen[i]) continue;
            const Pulse& pulse = *chosen[i];
            const Channel* channel = find_channel(model, pulses.camera_id, pulse.laser_id);
            const Eigen::Vector2f pixel = Eigen::Vector2f(pulse.u, pulse.v) + centres[i].shift_px;
            if (const auto hit = triangulate(*channel, pixel.cast<double>(), pulse.s))
                found[i].front().hit = *hit;
            else
                centres[i] = {};
        }
    });
    return centres;
}

}  // namespace

RangeResult range_from_pulses(const PulseMap& pulses, const ScannerModel& model,
                              const RangeOptions& options) {
    RangeResult result;
    RangeStatistics& statistics = result.statistics;
    statistics.pulses = pulses.pulses.size();
    for (const Pulse& pulse : pulses.pulses)
        if (!find_channel(model, pulses.camera_id, pulse.laser_id))
            throw Error("the scanner model has no channel for camera " +
                        std::to_string(pulses.camera_id) + " and laser " +
                        std::to_string(pulse.laser_id) + ", which this sweep used");

    auto found = triangulate_all(pulses, model, options, statistics);
    const double usual = median_over(found, [](const Candidate& c) { return c.width_ratio; });
    RangeImage& image = result.image;
    image = make_range_image(pulses.width, pulses.height);
    std::vector<Eigen::Vector2f> pixels(image.cell_count(), Eigen::Vector2f::Zero());
    std::vector<const Channel*> channels(image.cell_count(), nullptr);
    double from = 1e300, to = -1e300;
    const Channel* channel = model.channels.empty() ? nullptr : &model.channels.front();
    for (auto& cell : found)
        for (Candidate& candidate : cell) candidate.width_ratio /= usual;
    const std::vector<Merging> merging = merging_cells(found, options);
    for (auto& cell : found) {
        statistics.wrong_width += std::erase_if(cell, [&](const Candidate& candidate) {
            return candidate.width_ratio < options.min_width_ratio ||
                   candidate.width_ratio > options.max_width_ratio;
        });
        if (cell.size() > 1) ++statistics.cells_with_choice;
    }
    const bool cells_are_pixels =
        channel && channel->axis.kind == MachineKind::swept && pulses.mode == StripeMode::spacetime;
    if (cells_are_pixels) {
        const JudgeCounts judged =
            judge_swept_pulses(found, pulses.width, pulses.height, merging, model, pulses.camera_id,
                               options.axis_sigma_s);
        statistics.turned_away = judged.turned_away;
        statistics.ambiguous = judged.ambiguous;
        statistics.near_merging = judged.near_merging;
    } else {
        for (auto& cell : found) std::stable_sort(cell.begin(), cell.end(), better);
    }
    std::vector<CentreOfLight> centres;
    if (cells_are_pixels)
        centres = move_to_centres_of_light(found, pulses, model, options, statistics.footprint);
    for (std::size_t i = 0; i < found.size(); ++i) {
        auto& cell = found[i];
        if (cell.empty()) continue;
        const CentreOfLight centre = centres.empty() ? CentreOfLight{} : centres[i];
        image.mask[i] = 1;
        channel = find_channel(model, pulses.camera_id, cell.front().pulse->laser_id);
        image.points[i] = make_point(pulses, cell.front(), *channel, options, centre.sigma_px);
        pixels[i] = Eigen::Vector2f(cell.front().pulse->u, cell.front().pulse->v) + centre.shift_px;
        channels[i] = channel;
        from = std::min(from, cell.front().pulse->s);
        to = std::max(to, cell.front().pulse->s);
        for (std::size_t k = 1; k < cell.size(); ++k)
            image.further.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint8_t>(k),
                                     make_point(pulses, cell[k], *channel, options)});
        ++statistics.points;
        statistics.contradicted += cell.front().contradicted;
        statistics.partly_lit += centre.is_partly_lit;
    }
    if (channel) image.kind = channel->axis.kind;
    if (statistics.points > 0) {
        image.stations = make_stations(*channel, from, to);
        compute_normals(image, range_triangles(image));
        if (pulses.mode == StripeMode::spacetime && image.kind != MachineKind::swept)
            correct_light_change(image, channels);
        add_systematic(image, pixels, model, *channel, options.sensitivity_count);
    }
    statistics.median_sigma_mm = median_of(image, [](const RangePoint& p) { return p.sigma_mm; });
    statistics.median_systematic_mm =
        median_of(image, [](const RangePoint& p) { return p.sigma_systematic_mm; });
    return result;
}

}  // namespace stria
