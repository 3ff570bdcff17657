#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/core/camera_model.h"
#include "host/core/image.h"
#include "host/core/rigid3.h"
#include "host/core/scanner_model.h"
#include "host/core/tri_mesh.h"

/// What a simulated scanner is and what stands before it: the content of scene.toml. The scene's
/// world is the scan frame at s = 0, and every object moves with the part.
namespace stria {

/// [sensor]: what turns light into digital numbers (DN).
struct SceneSensor {
    double full_well_e = 10500;  ///< electrons a pixel holds
    double read_noise_e = 8;     ///< standard deviation
    double gain_e_per_dn = 40;   ///< electrons per DN at `bits`
    int bits = 8;                ///< 8..16
    double exposure_us = 1000;   ///< until the camera is configured otherwise
    double row_time_us = 0;      ///< 0: global shutter
    double black_dn = 0;         ///< DN of no light
    double min_frame_period_us = 2000;
    double pixel_um = 5;              ///< side of a pixel
    double f_number = 8;              ///< of the lens
    double quantum_efficiency = 0.5;  ///< electrons per photon
    bool noise = true;                ///< false: expected values, still quantised and clipped
    double prnu = 0;    ///< relative standard deviation of the pixels' sensitivity, 0..0.1
    double dsnu_e = 0;  ///< standard deviation of the pixels' dark offsets, electrons, 0..1000
    double dark_current_e_per_s =
        0;  ///< electrons a second and pixel, with their shot noise; 0..1e5
    /// Swept machines: pixels that a border crosses are cut along it (pixel_cells.h); false: 16
    /// rays count what lies on either side. True takes about three times as long before the first
    /// frame.
    bool cut_edges = false;
    double blooming = 0;  ///< share of the charge above full well that reaches the next pixel of
                          ///< the row, 0 (drained at once) .. 1 (none is lost)
    double gamma =
        1;  ///< response (DN - black) / (top - black) = (linear)^gamma, 0.3..3; 1: linear
};

/// [lens]: how the picture differs from a pinhole's. All off by default.
struct SceneLens {
    double psf_sigma_px = 0;  ///< standard deviation of its spot in focus, 0..8
    double focus_mm = 0;      ///< depth (camera z) in focus, 0: every depth is
    bool cos4 = false;        ///< natural vignetting, cos^4 of the angle from the axis
    double corner_loss =
        0;  ///< share of light lost in the farthest corner, growing as r^2; 0..0.95
};

/// [laser]: how far the line is from an even Gaussian one; bow is the sheet's own. Ideal by
/// default.
struct SceneLine {
    double ripple = 0;         ///< relative amplitude of waves along the line, 0..0.9
    double ripple_rad = 0.05;  ///< their period in fan angle, 0.001..3
    double falloff_rad = 0;    ///< standard deviation of a Gaussian fall towards the ends (cylinder
                               ///< lens) in fan angle, 0.05..3; 0: none (Powell lens)
    double m2 = 1;  ///< beam quality across the line, 1 (Gaussian) .. 20: z_R = 4 pi sigma0^2 /
                    ///< (M^2 lambda), the waist kept. The scanner's model (LaserSheet) has 1
    /// Across the line the profile is (G(x) + lobe G((x - d) / 2)) / (1 + 2 lobe), G the Gaussian
    /// of the sheet's width, d = lobe_shift of its standard deviations towards laser.normal.
    double lobe = 0;        ///< relative peak of the second Gaussian, 0..0.2
    double lobe_shift = 0;  ///< -4..4; not 0: the line is lopsided
    double ghost = 0;       ///< share of the power in each of two lines beside the line (the first
                            ///< orders of a diffractive optic), 0..0.2
    double ghost_rad = 0.02;  ///< between them and the line, seen from the apex, 0.001..0.5
};

enum class SpeckleModel : std::uint8_t { none, surface, screen };
inline constexpr std::array kSpeckleModels = {SpeckleModel::none, SpeckleModel::surface,
                                              SpeckleModel::screen};
/// "none", "surface", "screen".
const char* name_of(SpeckleModel model);

/// [laser.speckle]: the laser's light on rough surfaces is grainy. Off by default.
struct SceneSpeckle {
    SpeckleModel model = SpeckleModel::none;  ///< "none", "surface" (gamma, sticks to the objects),
                                              ///< "screen" (by the lens's aperture, swept only)
    /// Standard deviation over mean: surface, of a pixel's light, 0.02..1; screen, before the
    /// pixel averages, 0.7072 (light that a surface depolarises) .. 1 (polarised).
    double contrast = 1;
    double length_mm = 0.1;  ///< surface: integral of the normalised covariance; 0.005..10
};

/// [ambient]: even light from all sides, level (1 + flicker_depth cos(2 pi flicker_hz t)), t the
/// device's true time.
struct SceneFlicker {
    double hz = 100;   ///< twice the mains frequency for lamps, 1..10000
    double depth = 0;  ///< 0: steady .. 1
};

/// [reflection]: light that reaches a surface by way of another one, once. Swept machines only.
struct SceneReflection {
    bool bounce = false;   ///< what lit surfaces scatter onto others; shadows included
    bool mirrors = false;  ///< the sheet that plane mirrors (material = "mirror") throw on others
};

/// [axis]: AxisModel holds direction, mirror, table and delay; this is the drive.
struct SceneAxis {
    double min = 0, max = 0;  ///< travel, mm or rad
    double max_speed = 0;     ///< per second
    double sigma = 0;         ///< standard deviation of a logged position
    double log_period_us = 500;
    /// What the log does not know: the true position is
    /// l(t - lag) + periodic_error sin(2 pi l(t - lag) / periodic_length), l the logged one's mean.
    double periodic_error = 0;  ///< mm or rad; of a lead screw or an encoder, 0: none
    double periodic_length =
        1;              ///< mm or rad; at least 4 pi periodic_error, so that it never turns
    double wobble = 0;  ///< mm or rad, 0 or more: standard deviation of the true position about the
                        ///< logged one, drawn for each frame
    double lag_us = 0;  ///< of the drive behind its log (galvo), 0..1e5
};

enum class SceneShape : std::uint8_t { sphere, plane, mesh };

/// [[object]]: a body. A sphere is centred on its frame. A plane is the rectangle z = 0 from
/// corner_mm to corner_mm + size_mm, both faces alike. A mesh comes from `file` or from memory; a
/// vertex attribute "albedo" (1) multiplies its albedo.
struct SceneObject {
    std::string name;
    SceneShape shape = SceneShape::sphere;
    std::string file;                 ///< mesh; relative to the scene
    double mm_per_unit = 1;           ///< of the file
    double radius_mm = 0;             ///< sphere
    Eigen::Vector2d size_mm{0, 0};    ///< plane
    Eigen::Vector2d corner_mm{0, 0};  ///< plane; -size / 2 unless the scene says otherwise
    Rigid3 world_from_object;
    double albedo = 0.8;       ///< 0..1
    double roughness_rad = 0;  ///< Oren-Nayar slope deviation; 0: Lambert
    bool mirror = false;       ///< material = "mirror": returns nothing diffuse, mirrors `albedo`
    double specular = 0;       ///< share of the light in a glossy lobe, 0..1 with albedo; 0: none
    double gloss = 0.3;        ///< width of that lobe: GGX alpha, 0.05..1
    /// Translucent material: this share of the diffuse light that enters it (0..1; 0: none) leaves
    /// it about a point that lies free_path_mm along the refracted ray, spread by
    /// exp(-r / free_path_mm).
    double subsurface = 0;
    double free_path_mm = 0.5;      ///< transport length, 0.01..10
    double refractive_index = 1.4;  ///< 1..3
    /// Reflectance image, 0..255 as share of the albedo, laid on the frame's xy plane from the
    /// plane's corner (other shapes: the frame's origin), x along columns, y along rows, repeated.
    std::string texture;  ///< image file, relative to the scene
    Eigen::Vector2d texture_size_mm{0, 0};

    /// Loaded by read_scene, or set by the caller. Shared because scenes are copied.
    std::shared_ptr<const TriMesh> mesh;
    std::shared_ptr<const GreyImage> texture_image;
};

/// Where one object stands in a view.
struct ViewPose {
    std::string object;
    Rigid3 world_from_object;
};

/// [[view]]: one placement of the objects. Those without a pose stay where their own says.
struct SceneView {
    std::string name;
    std::vector<ViewPose> poses;      ///< [[view.pose]] object, world_from_object
    std::vector<std::string> hidden;  ///< objects that are not there
};

/// [nominal]: how far the design model that the device states differs from the truth, one standard
/// deviation. The design also knows no lens distortion, bow, non-linearity or delay, and takes the
/// image's centre for the principal point.
struct SceneNominal {
    double rotation_sigma_rad = 0.01;
    double position_sigma_mm = 1.0;
    double focal_relative_sigma = 0.01;
};

/// [fault]: what goes wrong.
struct SceneFault {
    double drop_frame_probability = 0;  ///< each frame's chance to be lost (a gap in the sequence)
    /// Each frame's chance to be delivered a second time, number, stamp and pixels alike.
    double duplicate_frame_probability = 0;
    double timing_jitter_us = 0;  ///< standard deviation of a frame's true start about its stamp
    double interlock_opens_at_s = -1;         ///< device time; negative: never
    std::int64_t camera_stops_at_frame = -1;  ///< sequence of the first frame never sent; -1: none
};

struct Scene {
    std::uint64_t seed = 1;
    Channel channel;  ///< the true geometry: camera, sheet (as it leaves the laser), axis
    SceneSensor sensor;
    SceneLens lens;
    SceneReflection reflection;
    double laser_power_mw = 30;  ///< in the sheet, at power 1
    SceneLine line;
    SceneSpeckle speckle;
    SceneAxis axis;
    std::vector<SceneObject> objects;
    std::vector<SceneView> views;  ///< empty: one, with every object where its own pose says
    double ambient_level = 0;      ///< share of full scale on albedo 1 at the sensor's exposure_us
    SceneFlicker flicker;          ///< of that light
    SceneNominal nominal;
    SceneFault fault;
};

/// Reads scene.toml and the files it names. Throws FileError: place, expected, found; an unknown
/// key names the nearest known one.
Scene read_scene(const std::string& path);
/// @param name      stands for the path in errors
/// @param base_dir  what relative file names start from
Scene parse_scene(const std::string& text, const std::string& name, const std::string& base_dir);
/// Text that parse_scene reads back. Meshes and textures from memory must be named by `file` and
/// `texture`; throws std::invalid_argument if one is not.
std::string format_scene(const Scene& scene);

/// The scene of `sim:` alone: a swept scanner before a sphere, a plate and a step.
Scene built_in_scene();

/// Empty if it can be simulated, else what is wrong (field, value, bound).
std::string validate(const Scene& scene);

/// Whether the lens spreads a point's light at all.
bool is_blurred(const SceneLens& lens);
/// Number of views, at least 1.
int view_count(const Scene& scene);
/// DN that cannot be exceeded: the lower of full well and converter, in electrons.
double full_scale_e(const SceneSensor& sensor);

}  // namespace stria
