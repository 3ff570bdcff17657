#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "host/core/image.h"
#include "host/scan/range_from_pulses.h"
#include "sim/scene.h"
#include "sim/scene_geometry.h"

/// Scans of scenes that throw light where it was not sent, from rendered frames with noise to a
/// range image, each point held against the surface that its pixel looks at.
namespace stria::test {

/// The scanner of a ghost scene.
struct GhostScanner {
    int width = 800, height = 200;  ///< px
    double beam_sigma_mm = 0.6;
    bool laser_on_left = false;  ///< of the camera, as the camera sees it
};

/// A scanner before a V-groove whose crease runs along the stripe.
struct Groove {
    double degrees = 80;  ///< between the faces
    double albedo = 0.9;
    /// From the direction half way between camera and laser to the groove's middle, degrees,
    /// positive: more of the far face is lit.
    double turned_degrees = 0;
};
Scene groove_scene(const Groove& groove, const GhostScanner& scanner = {});

/// A plate with an upright mirror beside it that throws a second stripe on the plate.
struct UprightMirror {
    double reflectance = 0.9;
    double floor_albedo = 0.8;
    double lean_degrees = 0;  ///< away from the plate it stands on
};
Scene mirror_scene(const UprightMirror& mirror, const GhostScanner& scanner = {});
/// The built-in scene's sphere, plate and step on the same scanner: nothing reflected.
Scene plain_scene(int width, int height);

/// Distance (mm) of a point from the surface along the rays of its pixel, the least of 5 x 5 over
/// its area: where an edge runs through the pixel either side is true. 1e9 where nothing is.
double distance_in_pixel(const SceneGeometry& geometry, const Channel& channel, std::size_t cell,
                         const RangePoint& point);

/// What became of each pixel whose surface camera and laser both see. Wrong: off along the ray by
/// more than max(5 sigma, sigma_b / 2).
struct GhostCount {
    std::size_t lit = 0;               ///< pixels whose surface the laser reaches
    std::size_t right = 0;             ///< of them: a point without warnings, not wrong
    std::size_t flagged = 0;           ///< of all: points with a warning
    std::size_t flagged_right = 0;     ///< of the lit pixels: not wrong, though with a warning
    std::size_t wrong = 0;             ///< of all: points without warnings that are wrong
    std::size_t wrong_partly_lit = 0;  ///< of these: in pixels that the sheet does not light all
    std::size_t points = 0;            ///< of all: points without warnings
    std::size_t several = 0;           ///< cells with more than one pulse before the choice
    /// Of the lit pixels: reflected light has its maximum within 1.5 standard deviations of the
    /// direct pulse (of that pulse in time) and is seen: they may be flagged.
    std::size_t close = 0;
    std::size_t close_right = 0;  ///< of them: a point without warnings, not wrong
    /// Of the lit pixels: the right pulse chosen, with a warning or without.
    double chosen_share() const {
        return static_cast<double>(right + flagged_right) / static_cast<double>(lit);
    }
    /// Of the lit pixels that are not close: the right pulse chosen and no warning.
    double right_share() const {
        return static_cast<double>(right - close_right) / static_cast<double>(lit - close);
    }
};

enum class GhostFate : std::uint8_t { dark, missing, right, flagged, wrong };

struct GhostScan {
    GhostCount count;
    RangeStatistics statistics;
    RangeResult range;
    PulseMap pulses;
    std::vector<GhostFate> fates;   ///< one a pixel, row-major
    std::vector<double> errors_mm;  ///< along the ray; NaN without a point
};

/// @param seed  of the noise
GhostScan scan_ghosts(const Scene& scene, unsigned seed, const RangeOptions& options = {});

/// White: right, yellow: flagged, red: wrong, grey: missed, black: nothing lit.
ColourImage picture_of(const GhostScan& scan);

}  // namespace stria::test
