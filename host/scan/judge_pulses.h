#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "firmware/core/pulse.h"
#include "host/core/scanner_model.h"

namespace stria {

/// A pulse that could be a surface point of its cell.
struct PulseCandidate {
    const Pulse* pulse = nullptr;
    Triangulation hit;
    double width_ratio = 1;     ///< measured over expected, over the scan's median of that
    double apart = 1e300;       ///< widths_apart
    std::uint16_t flags = 0;    ///< PulseFlag: what the point will carry
    bool contradicted = false;  ///< another pass should have seen it there and did not
    bool turned_away = false;   ///< the surface it would make with its neighbours shows its back
    int support = 0;            ///< neighbours of the 8 about it that continue its surface
};

/// How far the pulse stands from the nearest one of its cell that was fitted together with it, in
/// their widths (root mean square of the two). Infinite where it is alone, 0 where the fit saw that
/// it may be two and could not part them.
double widths_apart(const Pulse& pulse, std::span<const Pulse> cell);
constexpr double kParted =
    1.5;  ///< widths from which on the fit's places are as good as its sigmas

/// Whether two pulses run together in a cell. Surely: one is wider than the beam allows, or wider
/// than usual and the fit saw that it may be two. Soon: the fit parted two that stand within 3 of
/// their widths, so that in a cell beside it they may be one. Maybe: wider than usual and
/// misfitting.
enum class Merging : std::uint8_t { no, maybe, soon, surely };

struct JudgeCounts {
    std::size_t turned_away = 0;   ///< pulses that no surface lit from there can have
    std::size_t ambiguous = 0;     ///< cells where the choice stayed open: flagged
    std::size_t near_merging = 0;  ///< cells flagged because pulses run together about them
};

/// Orders the candidates of every cell of a swept spacetime map, the chosen one first, and sets
/// their flags. The map's cells are pixels, row-major.
///
/// A surface that camera and laser both see faces both; so where s grows from pixel to pixel
/// against the order of the sheet, light came by another way (accuracy.md A.1: inter-reflections
/// move opposite to direct pulses). The gradient of s comes from a plane through the nearest
/// candidates in 5 x 5 pixels; a pulse is turned away where it faces the laser's apex by less than
/// minus three standard deviations:
/// - turned away, or contradicted by another pass: kPulseGhostSuspected, behind all others;
/// - one left: chosen, what the analyser suspected by strength alone is taken back, and so is
///   kPulseOverlapping where two pulses 1.5 widths or more apart were fitted together;
/// - several left: the one that most of the 8 neighbours continue, of two that end here (a pixel on
///   an edge) the stronger, whose surface fills more of the pixel. Where 6 neighbours or more
///   continue a second one as well it is flagged kPulseGhostSuspected: two surfaces cannot both go
///   on through one pixel;
/// - near merging pulses a ghost is on its way into the pulse: kPulseOverlapping where two or more
///   cells surely merge within half a beam width of it (in pixels, on an even surface; a whole one
///   if its chi-square exceeds 2), or soon will if it is a single pulse, or, if it is wider than
///   usual and misfits itself, where two or more cells within a beam width may merge.
/// @param merging  one a cell
/// @param axis_sigma_s  standard deviation of s besides the pulses' own
JudgeCounts judge_swept_pulses(std::vector<std::vector<PulseCandidate>>& cells, int width,
                               int height, const std::vector<Merging>& merging,
                               const ScannerModel& model, std::uint8_t camera_id,
                               double axis_sigma_s);

}  // namespace stria
