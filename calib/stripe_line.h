#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calib/stripe_points.h"
#include "firmware/core/pulse.h"
#include "host/core/camera_model.h"
#include "host/core/rigid3.h"

namespace stria {

/// A stripe's crossing in one picture, whichever way the stripe runs.
struct StripePeak {
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    double sigma_px = 0;  ///< standard deviation along `across`
    double width_px = 0;  ///< of the stripe, Gaussian standard deviation
    Eigen::Vector2d across = Eigen::Vector2d::UnitX();  ///< pixel axis that it was found along
};

/// Peaks of find_peaks as places in the picture; `columns` says that it saw the picture transposed.
/// Those without a sigma, and those cut off by the picture's border, are left out.
std::vector<StripePeak> stripe_peaks(const std::vector<Pulse>& peaks, bool columns);

/// The straight stripe that a flat sheet draws on a flat board, board frame, mm.
struct StripeLine {
    std::string refusal;                  ///< empty if there is one, else why not, in words
    std::vector<Eigen::Vector2d> points;  ///< on the board, those used
    Eigen::Vector2d ends[2];              ///< of the line, at its outermost points
    Eigen::Vector2d normal = Eigen::Vector2d::UnitY();     ///< unit, across the line
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of the ends along `normal`, mm^2
    double rms_mm = 0;                                     ///< of the points across the line
    double chi_square = 0;  ///< per degree of freedom; above 1 it has raised the covariance
};

/// Line through the peaks that lie on the board between its outermost corners, where one colour
/// surrounds them (3 widths to each side: an edge of reflectance shifts a peak). Stray light is
/// left out: the line that most peaks agree with (random pairs, fixed seed), then weighted least
/// squares, Huber's first, plain at the end, without what lies 4 robust standard deviations off.
/// Refuses a stripe with fewer than 20 points or that covers less than 30 % of its way over the
/// board.
StripeLine stripe_line_on_board(const std::vector<StripePeak>& peaks, const CameraModel& camera,
                                const Rigid3& camera_from_board, const BoardColours& colours);

}  // namespace stria
