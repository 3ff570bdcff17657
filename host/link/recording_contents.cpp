#include "host/link/recording_contents.h"

#include <algorithm>

#include "firmware/protocol/pulse_bands.h"
#include "firmware/protocol/recording.h"
#include "host/core/errors.h"

namespace stria {

struct ContentsBuilder::State {
    std::string name;
    LoadOptions options;
    RecordingContents contents;
    PulseMapAssembler bands;
    std::size_t frame_bytes = 0;

    void add(Snapshot snapshot) { contents.snapshot = std::move(snapshot); }
    void add(Frame frame) {
        const bool is_off = frame.laser_power == 0;
        if (!is_off && options.on_frame) {
            options.on_frame(frame);
            return;
        }
        frame_bytes += frame.bytes.size();
        if (frame_bytes > options.max_bytes)
            throw FileError(name, "frame " + std::to_string(frame.sequence),
                            "its frames exceed " + std::to_string(options.max_bytes) +
                                " bytes of memory; take them one by one");
        (is_off ? contents.off_frames : contents.frames).push_back(std::move(frame));
    }
    void add(const AxisLog& log) {
        AxisLog& all = contents.axis_log;
        all.sigma_s = std::max(all.sigma_s, log.sigma_s);
        for (const AxisSample& sample : log.samples)
            if (all.samples.empty() || sample.t_ns > all.samples.back().t_ns)
                all.samples.push_back(sample);
    }
    void add(PulseBand band) {
        const bool is_first = band.first_row == 0;
        if (is_first) close_unfinished();
        if (auto map = bands.add(std::move(band))) contents.pulse_maps.push_back(std::move(*map));
    }
    void add(PathTable table) { contents.path_tables.push_back(std::move(table)); }
    void add(const Health&) {}
    void add(End end) { contents.end = std::move(end); }
    void add(const Request&) { refuse("request"); }
    void add(const Response&) { refuse("response"); }
    void refuse(const std::string& what) {
        contents.notes.push_back("a " + what + " does not belong into a recording");
    }

    void close_unfinished() {
        auto map = bands.unfinished();
        if (!map) return;
        contents.notes.push_back("the last rows of a pulse map are missing");
        contents.pulse_maps.push_back(std::move(*map));
    }

    void assign_positions() {
        if (contents.axis_log.samples.size() < 2) {
            if (!contents.pulse_maps.empty())
                contents.notes.push_back("no axis log: positions are the device's own");
            return;
        }
        for (PulseMap& map : contents.pulse_maps) {
            const std::size_t removed = assign_axis_positions(map, contents.axis_log);
            if (removed > 0)
                contents.notes.push_back(std::to_string(removed) +
                                         " pulses outside the axis log were left out");
        }
    }
};

ContentsBuilder::ContentsBuilder(std::string name, LoadOptions options)
    : state_(std::make_unique<State>()) {
    state_->name = std::move(name);
    state_->options = std::move(options);
}
ContentsBuilder::~ContentsBuilder() = default;

void ContentsBuilder::add(Message message) {
    std::visit([this](auto&& m) { state_->add(std::move(m)); }, std::move(message));
}

RecordingContents ContentsBuilder::finish() {
    state_->close_unfinished();
    state_->assign_positions();
    return std::move(state_->contents);
}

RecordingContents load_recording(const std::string& path, const LoadOptions& options) {
    auto reader = RecordingReader::open(path);
    if (!reader) throw Error(reader.failure().message);
    ContentsBuilder builder(path, options);
    builder.add(reader->snapshot());
    while (true) {
        auto message = reader->next();
        if (!message) throw Error(message.failure().message);
        if (!*message) break;
        builder.add(std::move(**message));
        if (options.on_progress) options.on_progress(reader->progress());
    }
    RecordingContents contents = builder.finish();
    for (const std::string& note : reader->notes()) contents.notes.push_back(note);
    if (!contents.end) contents.notes.push_back("no end message: the run broke off");
    return contents;
}

}  // namespace stria
