#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "calib/scanner_calibration.h"
#include "firmware/core/scan_plan.h"
#include "host/cli/command.h"
#include "host/link/recording_contents.h"

namespace stria {

/// Views of a board gathered so far, and the machine's drawing.
struct GatheredViews {
    std::vector<CornerView> views;
    std::vector<std::uint32_t> crcs;  ///< CRC-32C of what was measured, one a view
    ScannerModel nominal;
    bool has_nominal = false;
    bool simulated = true;  ///< every view comes from a simulated machine
};

/// Finds the board in a recording and adds it as a view; the first one's design model becomes the
/// nominal where none is known. `name` stands for the recording in messages.
void add_view(GatheredViews& gathered, const RecordingContents& contents, const Board& board,
              const std::string& name);

/// Whether the i-th of `usable` views is held out of the solve: every `every`-th (0: none), where
/// there are 10 or more.
bool is_held_out(std::size_t i, std::size_t usable, int every);

struct BoardCaptureOptions {
    std::string device;  ///< DEVICE
    ScanPlan plan;       ///< with off frames
    int views = 15;
    int check_every = 0;       ///< guided: which views the coach must not count on; 0: none
    bool guided = false;       ///< ask the coach where to hold the board
    std::string picture_path;  ///< guided: the SVG written before each view
};

/// Sweeps over a board with a device, one view a placement. Simulated devices place it themselves:
/// by the feature SceneView, or guided, where the coach asks for it (the scene's object with a
/// texture is the board, every other one is hidden). Otherwise the person is asked to, and presses
/// Enter. Guided views that show no usable board are not kept and asked for again, as often as
/// there are views. Throws stria::Error.
void capture_views(const Context& context, const Board& board, const BoardCaptureOptions& options,
                   GatheredViews& gathered);

}  // namespace stria
