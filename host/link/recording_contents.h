#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/protocol/messages.h"

namespace stria {

/// Everything that one run of a device brought.
struct RecordingContents {
    Snapshot snapshot;
    std::vector<Frame> off_frames;     ///< laser off (laser_power 0), in the order taken
    std::vector<Frame> frames;         ///< laser on, unless they were streamed or not recorded
    AxisLog axis_log;                  ///< the whole run, ascending in time
    std::vector<PulseMap> pulse_maps;  ///< one a sweep; s and ds_dt read from axis_log
    std::vector<PathTable> path_tables;
    std::optional<End> end;          ///< missing: the run broke off
    std::vector<std::string> notes;  ///< what was lost, "tail lost after byte N"; empty: nothing
};

struct LoadOptions {
    /// Takes every laser-on frame in turn; `frames` stays empty then.
    std::function<void(const Frame&)> on_frame;
    /// Share of the recording that has been read, 0..1.
    std::function<void(double)> on_progress;
    std::size_t max_bytes = std::size_t{4} << 30;  ///< of frames kept in memory
};

/// Reads a recording. A torn tail costs its last message and is noted; so is every damaged one.
/// Throws FileError if the file is no recording or its snapshot is not whole, and where the frames
/// to keep exceed max_bytes.
RecordingContents load_recording(const std::string& path, const LoadOptions& options = {});

/// Sorts messages of a run into its contents, one by one; what load_recording and a live run share.
class ContentsBuilder {
  public:
    /// @param name  stands for the recording in errors
    ContentsBuilder(std::string name, LoadOptions options);
    ~ContentsBuilder();
    ContentsBuilder(const ContentsBuilder&) = delete;
    ContentsBuilder& operator=(const ContentsBuilder&) = delete;

    void add(Message message);
    /// Axis positions assigned, an unfinished pulse map closed.
    RecordingContents finish();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace stria
