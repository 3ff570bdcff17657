#include "host/link/recording_contents.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "firmware/protocol/recording.h"
#include "host/core/errors.h"
#include "tests/firmware/protocol/samples.h"

namespace stria {
namespace {

namespace fs = std::filesystem;

class Contents : public testing::Test {
  protected:
    void SetUp() override {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = fs::path(testing::TempDir()) / (std::string("stria_contents_") + info->name());
        fs::create_directories(folder_);
        write_recording();
    }
    void TearDown() override { fs::remove_all(folder_); }

    std::string path(const char* name) const { return (folder_ / name).string(); }

    /// Two off frames, three frames, two logs, a map of every frame, an end.
    void write_recording() const {
        auto writer = RecordingWriter::create(path("whole.stria"), samples::snapshot());
        ASSERT_TRUE(writer);
        for (unsigned i = 0; i < 5; ++i) {
            Frame frame = samples::frame(16, 12, 8, i);
            frame.sequence = i;
            frame.laser_power = i < 2 ? 0.0F : 1.0F;
            ASSERT_TRUE(writer->write(frame));
        }
        PulseMap map = samples::pulse_map();
        for (Pulse& pulse : map.pulses) pulse.t_ns = 1500 + pulse.t_ns % 1000;
        AxisLog log = samples::axis_log();
        ASSERT_TRUE(writer->write(log));
        log.samples = {{4004, 1.0}, {9000, 2.0}};  // its first sample repeats the last one's time
        ASSERT_TRUE(writer->write(log));
        ASSERT_TRUE(writer->write(map));
        ASSERT_TRUE(writer->finish(samples::end()));
    }
    static std::string read(const std::string& file) {
        std::ifstream in(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }

    fs::path folder_;
};

TEST_F(Contents, AreSortedByKind) {
    const RecordingContents contents = load_recording(path("whole.stria"));
    EXPECT_EQ(contents.off_frames.size(), 2U);
    EXPECT_EQ(contents.frames.size(), 3U);
    EXPECT_EQ(contents.axis_log.samples.size(), 6U);
    ASSERT_EQ(contents.pulse_maps.size(), 1U);
    EXPECT_EQ(contents.pulse_maps[0].pulses.size(), samples::pulse_map().pulses.size());
    EXPECT_EQ(contents.end, samples::end());
    EXPECT_TRUE(contents.notes.empty());
}

TEST_F(Contents, PulsesTakeTheirPositionFromTheLog) {
    const RecordingContents contents = load_recording(path("whole.stria"));
    for (const Pulse& pulse : contents.pulse_maps[0].pulses) {
        const auto state = position_at(contents.axis_log, pulse.t_ns);
        ASSERT_TRUE(state);
        EXPECT_EQ(pulse.s, state->s);
        EXPECT_EQ(pulse.ds_dt, state->ds_dt);
    }
}

TEST_F(Contents, FramesCanBeTakenOneByOne) {
    std::vector<std::uint32_t> seen;
    double progress = 0;
    LoadOptions options;
    options.on_frame = [&](const Frame& frame) { seen.push_back(frame.sequence); };
    options.on_progress = [&](double share) { progress = share; };
    const RecordingContents contents = load_recording(path("whole.stria"), options);
    EXPECT_EQ(seen, (std::vector<std::uint32_t>{2, 3, 4}));
    EXPECT_TRUE(contents.frames.empty());
    EXPECT_EQ(contents.off_frames.size(), 2U);
    EXPECT_EQ(progress, 1.0);
}

TEST_F(Contents, MemoryForFramesIsBounded) {
    LoadOptions options;
    options.max_bytes = 500;  // two and a half frames
    EXPECT_THROW(load_recording(path("whole.stria"), options), FileError);
}

TEST_F(Contents, CutAnywhereTheyOpenMinusTheirTail) {
    const std::string bytes = read(path("whole.stria"));
    std::uint32_t snapshot_bytes = 0;
    std::memcpy(&snapshot_bytes, &bytes[12], 4);
    snapshot_bytes += 32;
    std::mt19937 rng(4);
    std::uniform_int_distribution<std::size_t> place(0, bytes.size() - 1);
    for (int i = 0; i < 1000; ++i) {
        const std::size_t size = place(rng);
        std::ofstream(path("cut.stria"), std::ios::binary) << bytes.substr(0, size);
        if (size < snapshot_bytes) {
            EXPECT_THROW(load_recording(path("cut.stria")), Error) << size;
            continue;
        }
        const RecordingContents contents = load_recording(path("cut.stria"));
        EXPECT_FALSE(contents.end);
        ASSERT_FALSE(contents.notes.empty()) << size;
        EXPECT_EQ(contents.notes.back(), "no end message: the run broke off");
        EXPECT_LE(contents.off_frames.size() + contents.frames.size(), 5U);
    }
}

TEST_F(Contents, WithoutALogThePositionsAreTheDevicesOwn) {
    auto writer = RecordingWriter::create(path("no_log.stria"), samples::snapshot());
    ASSERT_TRUE(writer && writer->write(samples::pulse_map()) && writer->finish(samples::end()));
    const RecordingContents contents = load_recording(path("no_log.stria"));
    EXPECT_EQ(contents.pulse_maps[0].pulses.size(), samples::pulse_map().pulses.size());
    ASSERT_EQ(contents.notes.size(), 1U);
    EXPECT_NE(contents.notes[0].find("no axis log"), std::string::npos);
}

}  // namespace
}  // namespace stria
