#pragma once
#include <functional>
#include <string>
#include <vector>

#include "calib/sheet_calibration.h"

namespace stria {

/// Photographs of a board with the stripe over it, one a placement.
struct SheetPhotographs {
    std::vector<std::string> with_stripe;
    std::vector<std::string> laser_off;  ///< the same placements in the same order, or empty
    std::string channel = "auto";        ///< which of colour images shows the stripe
    std::string axis = "auto";  ///< "rows", "columns": one peak in each; auto: what finds more
};

/// A photograph that shows no board, or not the same one twice.
struct RefusedPhotograph {
    std::string file, reason;
};

struct SheetViews {
    std::vector<SheetView> views;
    std::vector<RefusedPhotograph> refused;
};

/// Corners and stripe peaks of each placement. With laser-off pictures the board is found in these
/// and their light is subtracted; without, and with `channel` auto, the laser's colour alone is
/// searched (a board is grey and vanishes). Throws stria::Error, saying
/// what to do: not one laser-off picture for each, one that cannot be read or is not of the
/// camera's size, grey pictures without laser-off ones, a board that no placement shows (each with
/// its reason).
/// @param on_progress  called after each placement with the number of them done
SheetViews read_sheet_views(const SheetPhotographs& photographs, const Board& board,
                            const CameraModel& camera,
                            const std::function<void(std::size_t)>& on_progress);

}  // namespace stria
