#include "firmware/protocol/recording.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/firmware/protocol/samples.h"

namespace stria {
namespace {

namespace fs = std::filesystem;

class Recording : public testing::Test {
  protected:
    void SetUp() override {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = fs::path(testing::TempDir()) / (std::string("stria_recording_") + info->name());
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    std::string path(const char* name) const { return (folder_ / name).string(); }

    /// Snapshot, off frame, two frames, log, map, health, path table, end.
    std::string write_sample() const {
        const std::string file = path("sample.stria");
        auto writer = RecordingWriter::create(file, samples::snapshot(), 42);
        EXPECT_TRUE(writer);
        for (unsigned seed : {1U, 2U, 3U})
            EXPECT_TRUE(writer->write(samples::frame(16, 12, 8, seed)));
        EXPECT_TRUE(writer->write(samples::axis_log()));
        EXPECT_TRUE(writer->write(samples::pulse_map()));
        EXPECT_TRUE(writer->write(samples::health()));
        EXPECT_TRUE(writer->write(samples::path_table()));
        EXPECT_TRUE(writer->finish(samples::end()));
        return file;
    }

    static std::string read(const std::string& file) {
        std::ifstream in(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    std::string write(const std::string& bytes) const {
        const std::string file = path("other.stria");
        std::ofstream(file, std::ios::binary) << bytes;
        return file;
    }

    /// Byte offsets at which messages begin, and the size.
    static std::vector<std::size_t> borders(const std::string& bytes) {
        std::vector<std::size_t> found = {0};
        while (found.back() < bytes.size()) {
            std::uint32_t length = 0;
            std::memcpy(&length, &bytes[found.back() + 12], 4);
            found.push_back(found.back() + kHeaderBytes + length);
        }
        return found;
    }

    /// Number of messages after the snapshot.
    static std::size_t count(RecordingReader& reader) {
        std::size_t messages = 0;
        while (true) {
            auto next = reader.next();
            if (!next || !*next) return messages;
            ++messages;
        }
    }

    fs::path folder_;
};

TEST_F(Recording, GivesBackWhatWasWritten) {
    auto reader = RecordingReader::open(write_sample());
    ASSERT_TRUE(reader) << reader.failure().message;
    EXPECT_EQ(reader->snapshot().features, samples::features());
    std::vector<std::size_t> kinds;
    while (true) {
        auto next = reader->next();
        ASSERT_TRUE(next);
        if (!*next) break;
        kinds.push_back((*next)->index());
    }
    EXPECT_EQ(kinds, (std::vector<std::size_t>{1, 1, 1, 2, 3, 5, 4, 6}));
    EXPECT_TRUE(reader->notes().empty());
    EXPECT_FALSE(fs::exists(path("sample.stria.part")));
}

TEST_F(Recording, OfVersion1OpensForEver) {
    auto reader = RecordingReader::open(STRIA_GOLDEN "/recording_v1.stria");
    ASSERT_TRUE(reader) << reader.failure().message;
    EXPECT_EQ(reader->snapshot_message().header.session, 42U);
    EXPECT_EQ(reader->snapshot().features, samples::features());
    EXPECT_EQ(reader->snapshot().model_text, samples::snapshot().model_text);
    std::vector<Message> messages;
    for (auto next = reader->next(); next && *next; next = reader->next())
        messages.push_back(std::move(**next));
    EXPECT_TRUE(reader->notes().empty());
    ASSERT_EQ(messages.size(), 7U);
    EXPECT_EQ(std::get<Frame>(messages[0]).bytes, samples::frame(16, 12).bytes);
    EXPECT_EQ(std::get<Frame>(messages[1]).bytes, samples::frame(9, 4, 12).bytes);
    EXPECT_EQ(std::get<AxisLog>(messages[2]).samples.size(), 5U);
    EXPECT_EQ(std::get<PulseBand>(messages[3]).map.cell_begin, samples::pulse_map().cell_begin);
    EXPECT_EQ(std::get<PathTable>(messages[4]), samples::path_table());
    EXPECT_EQ(std::get<Health>(messages[5]), samples::health());
    EXPECT_EQ(std::get<End>(messages[6]), samples::end());
}

TEST_F(Recording, OpensUnderItsTemporaryNameBeforeItIsFinished) {
    const std::string file = path("open.stria");
    auto writer = RecordingWriter::create(file, samples::snapshot());
    ASSERT_TRUE(writer);
    EXPECT_FALSE(fs::exists(file));
    ASSERT_TRUE(writer->close());
    EXPECT_TRUE(RecordingReader::open(file));
}

TEST_F(Recording, RawMessagesMakeTheSameBytes) {
    const std::string file = write_sample();
    auto source = RecordingReader::open(file);
    ASSERT_TRUE(source);
    auto again = RecordingWriter::create(path("copy.stria"), source->snapshot(), 42);
    ASSERT_TRUE(again);
    while (true) {
        auto raw = source->next_raw();
        ASSERT_TRUE(raw);
        if (!*raw) break;
        ASSERT_TRUE(again->write_raw(**raw));
    }
    ASSERT_TRUE(again->close());
    EXPECT_EQ(read(path("copy.stria")), read(file));
}

TEST_F(Recording, CutAtEveryBorderLosesOnlyWhatFollows) {
    const std::string bytes = read(write_sample());
    const auto begin = borders(bytes);
    for (std::size_t i = 1; i < begin.size(); ++i) {
        auto reader = RecordingReader::open(write(bytes.substr(0, begin[i])));
        ASSERT_TRUE(reader) << i;
        EXPECT_EQ(count(*reader), i - 1);
        EXPECT_TRUE(reader->notes().empty());
    }
}

TEST_F(Recording, CutAnywhereOpensMinusItsTail) {
    const std::string bytes = read(write_sample());
    const auto begin = borders(bytes);
    std::mt19937 rng(8);
    std::uniform_int_distribution<std::size_t> place(0, bytes.size() - 1);
    for (int i = 0; i < 1000; ++i) {
        const std::size_t size = place(rng);
        auto reader = RecordingReader::open(write(bytes.substr(0, size)));
        if (size < begin[1]) {
            ASSERT_FALSE(reader) << size;
            continue;
        }
        ASSERT_TRUE(reader) << size << ": " << reader.failure().message;
        std::size_t whole = 0;
        while (whole + 1 < begin.size() && begin[whole + 1] <= size) ++whole;
        ASSERT_EQ(count(*reader), whole - 1) << size;
        const bool torn = begin[whole] != size;
        ASSERT_EQ(reader->notes().size(), torn ? 1U : 0U) << size;
        if (torn) {
            const std::string where = "tail lost after byte " + std::to_string(begin[whole]);
            EXPECT_EQ(reader->notes()[0].find(where), 0U) << reader->notes()[0];
        }
    }
}

TEST_F(Recording, ADamagedPayloadCostsOnlyItsMessage) {
    const std::string bytes = read(write_sample());
    const auto begin = borders(bytes);
    for (std::size_t i = 1; i + 1 < begin.size(); ++i) {
        std::string damaged = bytes;
        damaged[begin[i] + kHeaderBytes + 9] ^= 0x10;
        auto reader = RecordingReader::open(write(damaged));
        ASSERT_TRUE(reader);
        EXPECT_EQ(count(*reader), begin.size() - 3);
        EXPECT_EQ(reader->notes().size(), 1U);
    }
}

TEST_F(Recording, FlippedBitsNeverCrash) {
    const std::string bytes = read(write_sample());
    std::mt19937 rng(9);
    for (int i = 0; i < 500; ++i) {
        std::string damaged = bytes;
        damaged[rng() % bytes.size()] ^= static_cast<char>(1U << (rng() % 8));
        auto reader = RecordingReader::open(write(damaged));
        if (reader) {
            EXPECT_LT(count(*reader), borders(bytes).size());
            EXPECT_FALSE(reader->notes().empty());
        }
    }
}

TEST_F(Recording, SaysWhyAFileIsNone) {
    const auto refusal = [&](const std::string& file) {
        const auto reader = RecordingReader::open(file);
        EXPECT_FALSE(reader);
        return reader ? std::string() : reader.failure().message;
    };
    EXPECT_NE(refusal(path("missing.stria")).find("No such file"), std::string::npos);
    EXPECT_NE(refusal(folder_.string()).find("expected a file"), std::string::npos);
    EXPECT_NE(refusal(write("")).find("empty"), std::string::npos);
    EXPECT_NE(refusal(write(std::string(100, 'x'))).find("expected \"STRI\""), std::string::npos);
    EXPECT_NE(refusal(write("STRI")).find("snapshot is not whole"), std::string::npos);
}

TEST_F(Recording, CannotBeCreatedInAFolderThatIsMissing) {
    const auto writer = RecordingWriter::create(path("no/such/x.stria"), samples::snapshot());
    ASSERT_FALSE(writer);
    EXPECT_NE(writer.failure().message.find("cannot be created"), std::string::npos);
}

}  // namespace
}  // namespace stria
