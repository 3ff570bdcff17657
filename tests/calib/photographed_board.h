#pragma once
#include <Eigen/Core>
#include <optional>

#include "host/core/board.h"
#include "host/core/camera_model.h"
#include "host/core/image.h"
#include "host/core/rigid3.h"

/// Pictures of a board as a camera sees them, by ray casting: truth for detection and sheet tests.
namespace stria {

struct FlatSheet {
    Eigen::Vector3d normal;  ///< unit; normal . p = offset_mm
    double offset_mm;
};

struct PhotographOptions {
    double white = 190, black = 30, background = 90;  ///< DN
    double noise_dn = 1.5;
    double blur_px = 0.7;  ///< Gaussian standard deviation
    double margin_mm = 8;  ///< white paper around the pattern
    std::optional<FlatSheet> sheet = {};
    double laser_dn = 55;          ///< red light of the stripe on white
    double stripe_sigma_mm = 0.5;  ///< across the sheet
    /// A reflection of a lamp: light of that many DN at its centre, falling off as a Gaussian.
    double glare_dn = 0;
    Eigen::Vector2d glare_at = Eigen::Vector2d::Zero();  ///< px
    double glare_px = 60;                                ///< standard deviation
    /// Right of this column (px) a hand hides everything.
    double hidden_from = 1e9;
    unsigned seed = 1;
};

/// Red, green and blue.
ColourImage photograph(const CameraModel& camera, const Rigid3& camera_from_board,
                       const Board& board, const PhotographOptions& options = {});
/// The green channel alone: no laser in it.
GreyImage grey_photograph(const CameraModel& camera, const Rigid3& camera_from_board,
                          const Board& board, const PhotographOptions& options = {});

/// Board turned by `turn` (rotation vector, rad), its middle at `centre` (mm, camera frame).
Rigid3 board_at(const Board& board, const Eigen::Vector3d& centre, const Eigen::Vector3d& turn);

}  // namespace stria
