#include "host/cli/calibration_views.h"

#include <iterator>
#include <utility>

#include "host/cli/recording_range.h"
#include "host/core/errors.h"
#include "host/io/model_io.h"

namespace stria {
namespace {

GreyImage grey_of(const Frame& frame) {
    GreyImage image(frame.width, frame.height);
    if (frame.bits == 8) {
        image.values = frame.bytes;
        return image;
    }
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x)
            image.at(x, y) = static_cast<std::uint8_t>(frame.sample(x, y) >> (frame.bits - 8));
    return image;
}

}  // namespace

CalibrationView calibration_view_of(const RecordingContents& recording, const std::string& name) {
    if (recording.off_frames.empty())
        throw Error(name +
                    ": holds no image with the laser off, so the board cannot be seen; record with "
                    "off_frames = 1 or more in the plan");
    CalibrationView view;
    view.name = name;
    for (const Frame& frame : recording.off_frames) {
        const auto state =
            position_at(recording.axis_log, frame.exposure_start_ns + frame.exposure_ns / 2);
        if (!state)
            throw Error(name + ": the axis log does not reach laser-off frame " +
                        std::to_string(frame.sequence));
        view.images.push_back({grey_of(frame), state->s});
    }
    std::vector<PulseMap> passes = pulses_of_passes(recording, name);
    view.pulses = std::move(passes.front());
    view.further_passes.assign(std::make_move_iterator(passes.begin() + 1),
                               std::make_move_iterator(passes.end()));
    return view;
}

ScannerModel nominal_model_of(const RecordingContents& recording, const std::string& name) {
    const std::string& text = recording.snapshot.model_text;
    if (text.empty())
        throw Error(name +
                    ": the device stated no design model to start from; give one with --nominal");
    return parse_scanner(text, name);
}

}  // namespace stria
