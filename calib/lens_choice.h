#pragma once
#include <string>
#include <vector>

#include "calib/camera_calibration.h"

namespace stria {

/// A lens model on views that had no part in its solve.
struct LensTrial {
    LensKind lens = LensKind::pinhole;
    double held_out_rms_px = 0;  ///< over all views, each judged by the others' camera
    /// Log of a view's rms over that of the best model, mean over the views, and its standard
    /// error.
    double worse_by_log = 0, worse_by_sigma_log = 0;
    std::string failed;  ///< why it could not be solved; empty if it was
};

struct LensChoice {
    LensKind lens = LensKind::brown5;
    std::vector<LensTrial> trials;  ///< simplest first
};

/// The camera with another lens model: coefficients that it lacks become 0.
CameraModel with_lens(CameraModel camera, LensKind lens);

/// The simplest lens model that foretells views it has not seen as well as any. The views are dealt
/// into three parts; each part is measured with the camera of the other two, only the boards' poses
/// fitted, so that coefficients which follow noise cost instead of helping. A simpler model wins
/// unless it is worse by more than 2 standard errors of the views' paired ratios (of their logs:
/// a few boards at the image's corners, where all models extrapolate, must not drown the others).
/// Corners that no model explains are left out for all alike. Throws stria::Error with fewer than 6
/// usable views, or if no model can be solved. Source: cross-validation with the rule of standard
/// errors, Breiman et al. 1984.
LensChoice choose_lens(const std::vector<CameraView>& views, const Board& board, int width,
                       int height);

}  // namespace stria
