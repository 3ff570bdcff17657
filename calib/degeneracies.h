#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "calib/scanner_calibration.h"

namespace stria {

/// Known ways in which views leave parts of a scanner undetermined, or contradict its constants.
enum class Degeneracy : std::uint8_t {
    one_view,
    too_few_views,      ///< fewer than 3 different ones
    same_view,          ///< the board at the same place in all views
    no_tilt,            ///< every board faces the camera
    parallel_boards,    ///< tilted, but all to the same side
    one_depth,          ///< all at nearly the same distance
    centre_only,        ///< part of the image never covered
    one_stripe_line,    ///< of a fixed sheet: it can still turn about that line
    axis_unobservable,  ///< rail, table: pictures at one axis position only
    short_arc,          ///< table: pictures over less than 60 deg
    short_travel,       ///< rail: pictures over less than 4 % of the distance
    square_size,        ///< the board's lengths contradict the rail's or the drawing's
    axis_constant,      ///< steps per turn or per mm, or the mirror's angle, wrong
    narrow_sweep,       ///< mirror: stripe points over less than 2 deg of its turn
};

/// "parallel boards", "one depth", ...
const char* name_of(Degeneracy kind);

struct DegeneracyFinding {
    Degeneracy kind = Degeneracy::one_view;
    bool prevents = false;  ///< a result would mean nothing: refuse
    std::string text;       ///< what was found, with figures, and the view to add or what to check
};

/// What the findings judge by; from solved views or from views as they come.
struct CalibrationCoverage {
    std::vector<Eigen::Vector3d> board_normals;  ///< of the pictures, camera frame
    std::vector<Eigen::Vector2d> corner_pixels;
    std::vector<Eigen::Vector3d> stripe_in_camera;  ///< stripe points on the boards
    std::vector<double> picture_s;                  ///< axis positions of pictures used
};

/// Findings about where boards and stripes were. One cause gives one finding: boards without tilt
/// are not also called parallel, a single line of stripes not also one depth.
std::vector<DegeneracyFinding> judge_coverage(const CalibrationCoverage& seen, MachineKind kind,
                                              int image_width, int image_height);

/// Every finding about views before anything is solved, most serious first: board poses by PnP with
/// the nominal camera, so that thresholds leave room for a focal length wrong by a few percent.
/// Findings that prevent a result leave out the lesser ones that follow from them. Turning speed of
/// a mirror is read off the angle of the stripe points about the nominal mirror axis.
std::vector<DegeneracyFinding> find_degeneracies(const std::vector<CornerView>& views,
                                                 const Board& board, const ScannerModel& nominal);

/// After the solve: lengths of the machine that left the drawing by more than 4 of its stated
/// standard deviations (options.nominal_length_sigma_mm). Where the whole machine grew or shrank by
/// one factor the board's square size is named.
std::vector<DegeneracyFinding> find_contradictions(const ScannerModel& solved,
                                                   const ScannerModel& nominal,
                                                   double nominal_length_sigma_mm);

}  // namespace stria
