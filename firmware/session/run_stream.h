#pragma once
#include <cstdint>
#include <functional>
#include <optional>

#include "firmware/acquire/acquire.h"
#include "firmware/protocol/recording.h"
#include "firmware/session/outbox.h"

namespace stria {

/// Turns what a run brings into messages of the data channel, numbered from 0 in session `run`.
class RunStream : public AcquireSink {
  public:
    using Send = std::function<Status(const SharedMessage&)>;
    using Tell = std::function<void(const AcquireStatus&)>;

    RunStream(std::uint32_t run, Send send, Tell tell)
        : run_(run), send_(std::move(send)), tell_(std::move(tell)) {}

    /// Every message from now on is also written to that recording.
    Status spool_to(const std::string& path);
    Status begin(const Snapshot& snapshot);
    Status end(const End& end);
    /// Along which the run follows the light.
    Status take_path_table(const PathTable& table);
    Status take_frame(const Frame& frame) override;
    Status take_axis_log(const AxisLog& log) override;
    Status take_pulse_map(const PulseMap& map) override;
    void take_status(const AcquireStatus& status) override { tell_(status); }

  private:
    /// Numbered, and written to the spool.
    Result<SharedMessage> framed(MessageType type, Bytes payload);
    Status put(MessageType type, Bytes payload);

    const std::uint32_t run_;
    std::uint32_t sequence_ = 0;
    Send send_;
    Tell tell_;
    std::optional<RecordingWriter> spool_;
};

}  // namespace stria
