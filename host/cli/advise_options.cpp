#include "host/cli/advise_options.h"

#include <charconv>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "host/cli/quantity.h"
#include "host/core/errors.h"
#include "host/io/model_io.h"
#include "sim/scene.h"

namespace stria {
namespace {

/// Fields of a design; of them some can also be set on a scanner that is there.
struct Field {
    const char* option;
    Quantity quantity;
    const char* help;
    std::function<void(ScannerDesign&, double)> in_design;
    std::function<void(AdvisedScanner&, double)> in_scanner;  ///< empty: fixed by the file
};

/// A field of the sensor, or of another part that design and scanner share.
template <typename Part, typename Target>
Field shared(const char* option, Quantity quantity, const char* help,
             Part ScannerDesign::*in_design, Part AdvisedScanner::*in_scanner,
             Target Part::*field) {
    return {option, quantity, help,
            [=](ScannerDesign& d, double x) { d.*in_design.*field = static_cast<Target>(x); },
            [=](AdvisedScanner& s, double x) { s.*in_scanner.*field = static_cast<Target>(x); }};
}

template <typename Target>
Field sensor(const char* option, Quantity quantity, const char* help, Target SensorSpec::*field) {
    return shared(option, quantity, help, &ScannerDesign::sensor, &AdvisedScanner::sensor, field);
}

template <typename Target>
Field surface(const char* option, Quantity quantity, const char* help, Target SurfaceSpec::*field) {
    return shared(option, quantity, help, &ScannerDesign::surface, &AdvisedScanner::surface, field);
}

template <typename Target>
Field design_only(const char* option, Quantity quantity, const char* help,
                  Target ScannerDesign::*field) {
    return {option, quantity, help, [=](ScannerDesign& d, double x) { d.*field = x; }, {}};
}

/// Sets the albedo, and the brightest one with it where it must be.
void set_albedo(SurfaceSpec& part, double albedo) {
    part.albedo = albedo;
    if (albedo > part.brightest_albedo && albedo <= 1) part.brightest_albedo = albedo;
}

void set_bits(SensorSpec& part, double bits) {
    if (bits != std::floor(bits)) throw std::invalid_argument("--bits: expected a whole number");
    part.bits = static_cast<int>(std::min(1000.0, std::max(-1000.0, bits)));
}

void set_frame_rate(SensorSpec& part, double hz) {
    if (!(hz > 0)) throw std::invalid_argument("--frame-rate: expected above 0");
    part.frame_period_us = 1e6 / hz;
}

std::vector<Field> design_fields() {
    using D = ScannerDesign;
    return {
        design_only("--width", Quantity::length_mm,
                    "field of view across the camera's image, in the middle of the depth [200 mm]",
                    &D::width_mm),
        design_only("--baseline", Quantity::length_mm,
                    "camera to mirror (swept) or laser [from --sigma-z, else 25 deg]",
                    &D::baseline_mm),
        design_only("--sigma-z", Quantity::length_mm,
                    "wanted standard deviation in depth: the least baseline that gives it",
                    &D::sigma_z_mm),
        design_only("--wavelength", Quantity::wavelength_nm, "of the laser [650 nm]",
                    &D::wavelength_nm),
        design_only("--waist", Quantity::length_mm,
                    "standard deviation of the beam at its waist, a quarter of the 1/e^2 width "
                    "[so that the stripe is four footprints wide]",
                    &D::waist_sigma_mm),
        design_only("--waist-at", Quantity::length_mm,
                    "place of the waist from the mirror, or on rail and turntable from the laser "
                    "[at the mirror; on the object]",
                    &D::waist_at_mm),
        design_only("--fan", Quantity::angle_rad,
                    "full opening angle of the line [what the field "
                    "needs]",
                    &D::fan_rad),
        design_only("--laser-to-mirror", Quantity::length_mm, "swept: way of the beam [50 mm]",
                    &D::laser_to_mirror_mm),
    };
}

std::vector<Field> sensor_fields() {
    using S = SensorSpec;
    return {
        sensor("--pixel-pitch", Quantity::pitch_um, "side of a pixel [3.45 um]", &S::pixel_um),
        sensor("--f-number", Quantity::number, "of the lens [5.6]", &S::f_number),
        sensor("--full-well", Quantity::number, "electrons a pixel holds [10500]", &S::full_well_e),
        sensor("--read-noise", Quantity::number, "electrons [2.5]", &S::read_noise_e),
        {"--bits", Quantity::number, "of a sample [10]",
         [](ScannerDesign& d, double x) { set_bits(d.sensor, x); },
         [](AdvisedScanner& s, double x) { set_bits(s.sensor, x); }},
        sensor("--gain", Quantity::number, "electrons per digital number [full well over range]",
               &S::gain_e_per_dn),
        sensor("--quantum-efficiency", Quantity::number, "electrons per photon [0.5]",
               &S::quantum_efficiency),
        sensor("--lens-blur", Quantity::number, "aberrations, standard deviation in px [0.3]",
               &S::aberration_px),
        {"--frame-rate", Quantity::number, "frames a second [60]",
         [](ScannerDesign& d, double x) { set_frame_rate(d.sensor, x); },
         [](AdvisedScanner& s, double x) { set_frame_rate(s.sensor, x); }},
        sensor("--exposure", Quantity::time_us,
               "[what brings the brightest surface to 80 % of full scale]", &S::exposure_us),
    };
}

std::vector<Field> other_fields() {
    using S = SurfaceSpec;
    return {
        {"--power", Quantity::power_mw, "of the laser, in the line [5 mW]",
         [](ScannerDesign& d, double x) { d.power_mw = x; },
         [](AdvisedScanner& s, double x) { s.power_mw = x; }},
        {"--m-squared", Quantity::number, "beam quality across the line [1.2]",
         [](ScannerDesign& d, double x) { d.m_squared = x; },
         [](AdvisedScanner& s, double x) { s.m_squared = x; }},
        {"--albedo", Quantity::number, "of the surface [0.8]",
         [](ScannerDesign& d, double x) { set_albedo(d.surface, x); },
         [](AdvisedScanner& s, double x) { set_albedo(s.surface, x); }},
        surface("--brightest", Quantity::number, "albedo that must not saturate [0.9]",
                &S::brightest_albedo),
        surface("--incidence", Quantity::angle_rad,
                "of the light on the surface [the surface faces the camera]", &S::incidence_rad),
        surface("--reflectance-ratio", Quantity::number, "at edges of the paint [10]",
                &S::reflectance_ratio),
        surface("--hole-width", Quantity::length_mm, "of slots to see into [10 mm]",
                &S::hole_width_mm),
        surface("--speckle-contrast", Quantity::number,
                "before the pixel: 1 coherent, 0.71 depolarised, 0 none [1]", &S::speckle_contrast),
        surface("--ambient", Quantity::number, "share of full scale on white [0]",
                &S::ambient_level),
        {"--step", Quantity::position,
         "axis travel from frame to frame: mm on a rail, rad of a mirror or table [advised]",
         [](ScannerDesign& d, double x) { d.step = x; },
         [](AdvisedScanner& s, double x) { s.step = x; }},
        {"--axis-sigma", Quantity::position, "standard deviation of a logged position [0]",
         [](ScannerDesign& d, double x) { d.axis_sigma = x; },
         [](AdvisedScanner& s, double x) { s.axis_sigma = x; }},
    };
}

const std::vector<Field>& all_fields() {
    static const std::vector<Field> fields = [] {
        std::vector<Field> all = design_fields();
        for (const auto& more : {sensor_fields(), other_fields()})
            all.insert(all.end(), more.begin(), more.end());
        return all;
    }();
    return fields;
}

/// A step in deg or rad on a rail, or in mm on a mirror, is a mistake.
void check_position_unit(const Field& field, const std::string& text, MachineKind kind) {
    if (field.quantity != Quantity::position) return;
    const bool angle = text.ends_with("deg") || text.ends_with("rad");
    const bool length = text.ends_with("m") || text.ends_with("in");
    if (kind == MachineKind::rail ? angle : length)
        throw std::invalid_argument(
            std::string(field.option) + " '" + text + "': expected " +
            (kind == MachineKind::rail ? "a length on a rail" : "an angle on a mirror or table"));
}

void set_pixels(const std::string& text, int& width, int& height) {
    const char* const end = text.data() + text.size();
    const auto first = std::from_chars(text.data(), end, width);
    if (first.ec == std::errc() && first.ptr != end && *first.ptr == 'x') {
        const auto second = std::from_chars(first.ptr + 1, end, height);
        if (second.ec == std::errc() && second.ptr == end) return;
    }
    throw std::invalid_argument("--pixels '" + text + "': expected WIDTHxHEIGHT as in 1456x1088");
}

SensorSpec sensor_of(const SceneSensor& scene) {
    SensorSpec sensor;
    sensor.pixel_um = scene.pixel_um;
    sensor.f_number = scene.f_number;
    sensor.full_well_e = scene.full_well_e;
    sensor.read_noise_e = scene.read_noise_e;
    sensor.bits = scene.bits;
    sensor.gain_e_per_dn = scene.gain_e_per_dn;
    sensor.black_dn = scene.black_dn;
    sensor.quantum_efficiency = scene.quantum_efficiency;
    sensor.aberration_px = 0;  // a simulated lens has none
    sensor.frame_period_us = std::max(scene.min_frame_period_us, scene.exposure_us);
    sensor.exposure_us = scene.exposure_us;
    return sensor;
}

}  // namespace

void AdviseOptions::declare(Arguments& arguments) {
    arguments.option("--scene", scene_, "advice for the scanner of this scene.toml");
    arguments.option("--model", model_, "advice for this calibrated scanner (scanner.toml)");
    arguments.option("--channel", channel_, "of the model, counted from 0; -1: its only one");
    arguments.option("--kind", kind_, "swept (a mirror), rail or turntable [swept]");
    arguments.option("--distance", texts_["--distance"],
                     "camera to the middle of the depth [400 mm; where the stripe crosses the "
                     "camera's axis]");
    arguments.option("--depth", texts_["--depth"],
                     "from the nearest to the farthest surface [a fifth of the distance]");
    arguments.flag(
        "--perfect-lens", perfect_lens_,
        "no diffraction, defocus or blur, as in the simulator: to compare with its scans");
    std::string cameras = "named camera:";
    for (const NamedCamera& camera : named_cameras()) cameras += " " + camera.name;
    arguments.option("--camera", camera_, cameras);
    arguments.option("--pixels", pixels_, "WIDTHxHEIGHT of the camera [1456x1088]");
    for (const Field& field : all_fields())
        arguments.option(field.option, texts_[field.option], field.help);
}

ScannerDesign AdviseOptions::design(const Context& context) const {
    if (channel_ != -1) throw std::invalid_argument("--channel: expected with --model only");
    ScannerDesign design;
    if (!kind_.empty()) {
        const auto kind = machine_kind_from(kind_);
        if (!kind)
            throw std::invalid_argument("--kind '" + kind_ +
                                        "': expected swept, rail or turntable");
        design.kind = *kind;
    }
    if (!camera_.empty()) {
        const NamedCamera& camera = named_camera(camera_);
        design.width_px = camera.width;
        design.height_px = camera.height;
        design.sensor = camera.sensor;
    }
    if (!pixels_.empty()) set_pixels(pixels_, design.width_px, design.height_px);
    design.sensor.perfect_lens = perfect_lens_;
    const double unit = context.mm_per_unit();
    const auto length = [&](const char* option, double otherwise) {
        const std::string& text = texts_.at(option);
        return text.empty() ? otherwise : parse_quantity(option, text, Quantity::length_mm, unit);
    };
    design.distance_mm = length("--distance", design.distance_mm);
    design.depth_mm = length("--depth", 0.2 * design.distance_mm);
    for (const Field& field : all_fields()) {
        const std::string& text = texts_.at(field.option);
        if (text.empty()) continue;
        check_position_unit(field, text, design.kind);
        field.in_design(design, parse_quantity(field.option, text, field.quantity, unit));
    }
    return design;
}

AdvisedScanner AdviseOptions::read_existing() const {
    AdvisedScanner scanner;
    if (!model_.empty()) {
        const ScannerModel model = read_scanner(model_);
        const int count = static_cast<int>(model.channels.size());
        if (channel_ < -1 || channel_ >= count || (channel_ == -1 && count > 1))
            throw std::invalid_argument("--channel " + std::to_string(channel_) + ": " + model_ +
                                        " has channels 0 to " + std::to_string(count - 1));
        scanner.channel = model.channels[static_cast<std::size_t>(std::max(0, channel_))];
        if (!camera_.empty()) scanner.sensor = named_camera(camera_).sensor;
        return scanner;
    }
    if (!camera_.empty()) throw std::invalid_argument("--camera: the camera is fixed by " + scene_);
    const Scene scene = read_scene(scene_);
    scanner.channel = scene.channel;
    scanner.sensor = sensor_of(scene.sensor);
    scanner.power_mw = scene.laser_power_mw;
    scanner.surface.ambient_level = scene.ambient_level;
    scanner.axis_sigma = scene.axis.sigma;
    scanner.travel = AxisRange{scene.axis.min, scene.axis.max};
    return scanner;
}

void AdviseOptions::place_depths(const Context& context, AdvisedScanner& scanner) const {
    const double unit = context.mm_per_unit();
    const std::string& distance = texts_.at("--distance");
    const std::string& depth = texts_.at("--depth");
    if (!distance.empty()) {
        scanner.middle_mm = parse_quantity("--distance", distance, Quantity::length_mm, unit);
    } else {
        const CameraModel& camera = scanner.channel.camera;
        const double s = scanner.travel ? (scanner.travel->from + scanner.travel->to) / 2 : 0;
        const Eigen::Vector2d middle(0.5 * (camera.width - 1), 0.5 * (camera.height - 1));
        const auto hit = triangulate(scanner.channel, middle, s);
        if (!hit)
            throw Error("the sheet does not meet the camera's axis at s = " + std::to_string(s) +
                        ": state --distance");
        const Rigid3 camera_from_scan = scan_from_camera(scanner.channel, s).inverse();
        scanner.middle_mm = (camera_from_scan * hit->point_in_scan).z();
    }
    const double span = depth.empty() ? 0.2 * scanner.middle_mm
                                      : parse_quantity("--depth", depth, Quantity::length_mm, unit);
    if (!(span >= 0)) throw std::invalid_argument("--depth '" + depth + "': expected 0 or more");
    scanner.near_mm = scanner.middle_mm - span / 2;
    scanner.far_mm = scanner.middle_mm + span / 2;
    scanner.focus_mm = scanner.middle_mm;
}

AdvisedScanner AdviseOptions::existing(const Context& context) const {
    const std::string file = scene_.empty() ? model_ : scene_;
    if (channel_ != -1 && model_.empty())
        throw std::invalid_argument("--channel: expected with --model only");
    if (!scene_.empty() && !model_.empty())
        throw std::invalid_argument("--scene and --model: expected one of them");
    for (const auto& [option, text] : {std::pair{"--kind", kind_}, {"--pixels", pixels_}})
        if (!text.empty())
            throw std::invalid_argument(std::string(option) + ": it is fixed by " + file);
    AdvisedScanner scanner = read_existing();
    scanner.sensor.perfect_lens = perfect_lens_;
    for (const Field& field : all_fields()) {
        const std::string& text = texts_.at(field.option);
        if (text.empty()) continue;
        if (!field.in_scanner)
            throw std::invalid_argument(std::string(field.option) + ": it is fixed by " + file);
        check_position_unit(field, text, scanner.channel.axis.kind);
        field.in_scanner(scanner,
                         parse_quantity(field.option, text, field.quantity, context.mm_per_unit()));
    }
    place_depths(context, scanner);
    return scanner;
}

}  // namespace stria
