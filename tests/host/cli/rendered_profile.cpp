#include "tests/host/cli/rendered_profile.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "firmware/stripe/spacetime.h"
#include "firmware/stripe/spatial.h"
#include "host/local/local_scanner.h"
#include "host/scan/centre_of_light.h"

namespace stria::test_support {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kAngle = std::numbers::pi / 6;  // between beam and line of sight
constexpr double kDistance = 450;                // of the surface from the camera
const Vector3d kMiddle(0, 0, -kDistance);        // scan frame
constexpr double kHalfCard = 36, kRunOutWidths = 7;

/// The camera looks at the middle along z; the mirror stands beside it, the laser beyond.
Channel channel_of(double beam_mm) {
    Channel channel;
    CameraModel& camera = channel.camera;
    camera.width = 320;
    camera.height = kProfileRows;
    camera.fx = camera.fy = kDistance / kPixelMm;
    camera.cx = 0.5 * (camera.width - 1) + 0.2;
    camera.cy = 0.5 * (camera.height - 1);
    const Vector3d mirror(kDistance * std::tan(kAngle), 0, 0), target(0, 0, kDistance);
    const Vector3d in(-1, 0, 0), out = (target - mirror).normalized();
    LaserSheet& sheet = channel.sheet;
    sheet.apex = mirror - 80 * in;
    sheet.central_ray = in;
    sheet.normal = sheet.central_ray.cross(Vector3d::UnitY()).normalized();
    sheet.offset_mm = sheet.normal.dot(sheet.apex);
    sheet.fan_rad = 0.2;
    sheet.waist_sigma_mm = beam_mm;
    sheet.waist_at_mm = 80 + (target - mirror).norm();
    sheet = normalised(sheet);
    channel.axis.kind = MachineKind::swept;
    channel.axis.mirror.direction = Vector3d::UnitY();
    channel.axis.mirror.point = mirror;
    channel.axis.mirror.normal0 = (out - in).normalized();
    return channel;
}

RenderedProfile empty_profile(double beam_mm, double psf_sigma_px) {
    RenderedProfile made;
    Scene& scene = made.scene;
    scene.channel = channel_of(beam_mm);
    scene.sensor.noise = false;
    scene.sensor.bits = 16;
    scene.sensor.full_well_e = 4300;
    scene.sensor.gain_e_per_dn = 4300.0 / 65535;
    scene.sensor.exposure_us = 100;
    scene.lens.psf_sigma_px = psf_sigma_px;
    scene.laser_power_mw = 20 * beam_mm;
    scene.ambient_level = 0;
    scene.axis = {.min = -0.2, .max = 0.2, .max_speed = 50, .sigma = 0};
    return made;
}

/// The beam goes from -reach to reach, four frames a width.
void set_sweep(RenderedProfile& profile, double beam_mm, double reach_mm) {
    const double arm = 2 * kDistance / std::cos(kAngle);  // the beam turns twice the mirror
    profile.plan.mode = StripeMode::spacetime;
    profile.plan.record = RecordWhat::frames;
    profile.plan.step = 0.25 * beam_mm / arm;
    profile.plan.to = reach_mm / arm;
    profile.plan.from = -profile.plan.to;
}

/// Z turned about y by the angle from the camera's direction towards the laser; X and Y a little
/// about Z, so that edges cross the rows' pixels at every phase.
Matrix3d profile_axes(double angle) {
    constexpr double kSlant = 0.14;  // rad: a pixel over the rows
    Matrix3d axes, slant;
    axes << std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0, std::cos(angle);
    slant << std::cos(kSlant), -std::sin(kSlant), 0, std::sin(kSlant), std::cos(kSlant), 0, 0, 0, 1;
    return axes * slant;
}

SceneObject plate(const std::string& name, const RenderedProfile& profile,
                  const SurfacePiece& piece) {
    SceneObject object;
    object.name = name;
    object.shape = SceneShape::plane;
    const Vector3d along =
        (profile.scan_from_profile * Vector3d(piece.x1 - piece.x0, 0, piece.z1 - piece.z0));
    const Vector3d x = along.normalized(), y = profile.scan_from_profile.col(1);
    Matrix3d turn;
    turn << x, y, x.cross(y);
    object.size_mm = {along.norm(), 20};
    object.corner_mm = {0, -10};
    object.albedo = 0.8;
    object.world_from_object = {
        turn, kMiddle + profile.scan_from_profile * Vector3d(piece.x0, 0, piece.z0)};
    return object;
}

/// A profile square to the beam: the camera sees it turned by the angle.
RenderedProfile lit_squarely(double beam_mm, double ratio) {
    const double wanted_px = ratio * beam_mm * std::cos(kAngle) / kPixelMm;
    RenderedProfile made =
        empty_profile(beam_mm, std::sqrt(std::max(0.0, wanted_px * wanted_px - 1.0 / 12)));
    made.scan_from_profile = profile_axes(kAngle);
    made.beam_mm = beam_mm;
    made.footprint_mm = ratio * beam_mm;
    made.pitch_mm = 0.25 * beam_mm;
    return made;
}

void add_pieces(RenderedProfile& profile, const std::vector<SurfacePiece>& pieces) {
    profile.pieces = pieces;
    for (std::size_t i = 0; i < pieces.size(); ++i)
        profile.scene.objects.push_back(plate("piece " + std::to_string(i), profile, pieces[i]));
}

/// Points of a profile from pixels and axis positions.
class Placing {
  public:
    Placing(const RenderedProfile& profile, const AxisLog& log) : profile_(profile), log_(log) {}

    void place(std::vector<ProfilePoint>& points, double u, double v, double s) const {
        const auto hit = triangulate(profile_.scene.channel, {u, v}, s);
        if (!hit) return;
        const Vector3d at = profile_.scan_from_profile.transpose() * (hit->point_in_scan - kMiddle);
        points.push_back({at.x(), at.z()});
    }
    double axis_at(const Frame& frame) const {
        return position_at(log_, frame.row_time(0)).value().s;
    }

  private:
    const RenderedProfile& profile_;
    const AxisLog& log_;
};

/// Sum and first moment of light.
struct Moment {
    double sum = 0, first = 0;
    void add(double light, double at) {
        sum += light;
        first += light * at;
    }
};

void add_moments(const RecordingContents& sweep, const Placing& placing, LocatedProfile& told) {
    const Frame& first = sweep.frames.front();
    std::vector<Moment> over_time(static_cast<std::size_t>(first.width) *
                                  static_cast<std::size_t>(first.height));
    const auto pixel_at = [&](int u, int v) {
        return static_cast<std::size_t>(v) * static_cast<std::size_t>(first.width) +
               static_cast<std::size_t>(u);
    };
    std::vector<std::pair<Moment, double>> rows;  // and the axis there
    for (const Frame& frame : sweep.frames) {
        const double s = placing.axis_at(frame);
        for (int v = 0; v < frame.height; ++v) {
            Moment row;
            for (int u = 0; u < frame.width; ++u) {
                const int light = frame.sample(u, v);
                told.greatest_dn = std::max(told.greatest_dn, light);
                row.add(light, u);
                over_time[pixel_at(u, v)].add(light, s);
            }
            rows.emplace_back(row, s);
        }
    }
    double most = 0;
    for (const auto& [row, s] : rows) most = std::max(most, row.sum);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto& [row, s] = rows[i];
        if (row.sum > 0.02 * most)
            placing.place(told.row_moments, row.first / row.sum,
                          static_cast<double>(i % static_cast<std::size_t>(first.height)), s);
    }
    most = 0;
    for (const Moment& pixel : over_time) most = std::max(most, pixel.sum);
    for (int v = 0; v < first.height; ++v)
        for (int u = 0; u < first.width; ++u) {
            const Moment& pixel = over_time[pixel_at(u, v)];
            if (pixel.sum > 0.02 * most)
                placing.place(told.pixel_moments, u, v, pixel.first / pixel.sum);
        }
}

}  // namespace

RenderedProfile rendered_card(double contrast, double beam_mm, double psf_sigma_px) {
    RenderedProfile made = empty_profile(beam_mm, psf_sigma_px);
    made.scan_from_profile = profile_axes(0);
    made.beam_mm = beam_mm / std::cos(kAngle);
    made.footprint_mm = kPixelMm * std::sqrt(1.0 / 12 + psf_sigma_px * psf_sigma_px);
    made.pitch_mm = 0.25 * made.beam_mm;
    set_sweep(made, beam_mm, kRunOutWidths * beam_mm);
    made.pieces = {{-kHalfCard, 0, kHalfCard, 0}};
    SceneObject card = plate("card", made, made.pieces[0]);
    GreyImage halves;
    halves.width = 7200;  // 0.01 mm
    halves.height = 1;
    for (int x = 0; x < halves.width; ++x)
        halves.values.push_back(
            static_cast<std::uint8_t>(std::lround(x < halves.width / 2 ? 250 : 250 / contrast)));
    card.texture = "halves.png";
    card.texture_image = std::make_shared<const GreyImage>(halves);
    card.texture_size_mm = {2 * kHalfCard, 20};
    made.scene.objects = {card};
    return made;
}

RenderedProfile rendered_corner(double degrees, bool roof, double ratio) {
    RenderedProfile made = lit_squarely(1, ratio);
    set_sweep(made, made.beam_mm, kRunOutWidths * made.beam_mm);
    const double half = 0.5 * degrees * std::numbers::pi / 180, x = 14;
    const double fall = (roof ? -1 : 1) * x / std::tan(half);
    add_pieces(made, {{-x, fall, 0, 0}, {0, 0, x, fall}});
    return made;
}

RenderedProfile rendered_strip(double ratio) {
    RenderedProfile made = lit_squarely(4.0 / 6, ratio);
    set_sweep(made, made.beam_mm, 14 * made.beam_mm);  // beyond the shadow that the camera sees
    const double down = -10 * made.beam_mm;
    add_pieces(made, {{-2, 0, 2, 0}, {-25, down, 25, down}});
    return made;
}

LocatedProfile located(const RenderedProfile& profile, int most_a_row) {
    LocalScanner scanner(profile.scene);
    const RecordingContents sweep = scanner.run(profile.plan);
    const SensorNoise& noise = sweep.snapshot.device.noise;
    const Placing placing(profile, sweep.axis_log);
    LocatedProfile told;
    add_moments(sweep, placing, told);
    SpatialOptions spatial;
    spatial.method = PeakMethod::centre_of_gravity;
    spatial.max_peaks_per_row = most_a_row;
    const Frame& first = sweep.frames.front();
    SpacetimeAnalyser spacetime(first.width, first.height, first.bits, noise);
    for (const Frame& frame : sweep.frames) {
        for (const Pulse& peak : find_peaks(frame, noise, spatial))
            placing.place(told.peaks, peak.u, peak.v, placing.axis_at(frame));
        spacetime.add(frame);
    }
    PulseMap map = spacetime.finish();
    assign_axis_positions(map, sweep.axis_log);
    std::vector<const Pulse*> chosen(map.cell_begin.size() - 1, nullptr);
    for (std::size_t i = 0; i < chosen.size(); ++i)
        if (map.cell_begin[i] < map.cell_begin[i + 1]) chosen[i] = &map.pulses[map.cell_begin[i]];
    const double psf_px = profile.scene.lens.psf_sigma_px;
    const auto centres =
        centres_of_light(chosen, map.width, map.height, std::sqrt(1.0 / 12 + psf_px * psf_px));
    for (const Pulse& pulse : map.pulses)
        if ((pulse.flags & (kPulseTouchesSequenceEnd | kPulseOverlapping)) == 0)
            placing.place(told.pulses, pulse.u, pulse.v, pulse.s);
    for (std::size_t i = 0; i < chosen.size(); ++i)
        if (const Pulse* pulse = chosen[i];
            pulse && (pulse->flags & (kPulseTouchesSequenceEnd | kPulseOverlapping)) == 0) {
            const Eigen::Vector2f at = Eigen::Vector2f(pulse->u, pulse->v) + centres[i].shift_px;
            placing.place(told.centred, at.x(), at.y(), pulse->s);
        }
    return told;
}

double greatest_error(const RenderedProfile& profile, const std::vector<ProfilePoint>& points,
                      double within_mm) {
    double worst = 0;
    for (const ProfilePoint& at : points) {
        if (std::abs(at.x) > within_mm) continue;
        for (const SurfacePiece& piece : profile.pieces)
            if (at.x >= piece.x0 && at.x <= piece.x1)
                worst = std::max(worst, std::abs(at.z - piece.height_at(at.x)));
    }
    return worst / profile.beam_mm;
}

Curl curl_of(const RenderedProfile& profile, const std::vector<ProfilePoint>& points,
             double pitch_mm) {
    Curl curl;
    for (const ProfilePoint& at : points) {
        double nearest = 1e9;
        for (const SurfacePiece& piece : profile.pieces) {
            const Vector2d a(piece.x0, piece.z0), b(piece.x1, piece.z1), p(at.x, at.z);
            const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
            nearest = std::min(nearest, (p - a - t * (b - a)).norm());
        }
        const double off = nearest / profile.beam_mm;
        if (off > 0.1) curl.length += pitch_mm / profile.beam_mm / kProfileRows;
        curl.worst = std::max(curl.worst, off);
    }
    return curl;
}

}  // namespace stria::test_support
