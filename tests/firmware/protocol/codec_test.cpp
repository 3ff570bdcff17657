#include "firmware/protocol/codec.h"

#include <gtest/gtest.h>

#include <limits>

#include "firmware/protocol/compress.h"
#include "firmware/protocol/validate.h"
#include "tests/firmware/protocol/samples.h"

namespace stria {
namespace {

Bytes encoded(const Message& message) {
    return std::visit([](const auto& m) { return encode(m); }, message);
}

std::string complaint_about(const Message& message) {
    return std::visit([](const auto& m) { return validate(m); }, message);
}

// Encoding is a pure function of the fields, so equal bytes after a round trip mean equal fields;
// the tests below compare fields one by one, too.
TEST(Codec, EveryMessageReturnsAsItWas) {
    for (const Message& message : samples::all()) {
        ASSERT_EQ(complaint_about(message), "");
        const Bytes payload = encoded(message);
        const auto decoded = decode(type_of(message), payload);
        ASSERT_TRUE(decoded) << decoded.failure().message;
        ASSERT_EQ(decoded->index(), message.index());
        EXPECT_EQ(encoded(*decoded), payload) << "message type " << message.index();
    }
}

template <typename T>
T round_trip(const T& message) {
    return std::get<T>(*decode(type_of(Message(message)), encode(message)));
}

TEST(Codec, FramesKeepPixelsAndEveryField) {
    for (int bits : {8, 10, 16}) {
        const Frame a = samples::frame(33, 21, bits);
        const Frame b = round_trip(a);
        EXPECT_EQ(a.bytes, b.bytes);
        EXPECT_EQ(
            std::tie(a.width, a.height, a.bits, a.camera_id, a.laser_id, a.exposure_index,
                     a.laser_power, a.exposure_start_ns, a.exposure_ns, a.row_time_ns, a.sequence),
            std::tie(b.width, b.height, b.bits, b.camera_id, b.laser_id, b.exposure_index,
                     b.laser_power, b.exposure_start_ns, b.exposure_ns, b.row_time_ns, b.sequence));
    }
}

TEST(Codec, SnapshotsKeepFeaturesPlanAndModel) {
    const Snapshot a = samples::snapshot(), b = round_trip(a);
    EXPECT_EQ(a.features, b.features);
    EXPECT_EQ(a.model_text, b.model_text);
    EXPECT_EQ(a.clock_ns, b.clock_ns);
    EXPECT_EQ(a.plan.exposures_us, b.plan.exposures_us);
    EXPECT_EQ(a.plan.lasers, b.plan.lasers);
    EXPECT_EQ(a.plan.step, b.plan.step);
    EXPECT_EQ(a.plan.record, b.plan.record);
    EXPECT_EQ(a.device.kind, b.device.kind);
    EXPECT_EQ(a.device.noise.black_dn, b.device.noise.black_dn);
    EXPECT_EQ(a.device.axis_sigma, b.device.axis_sigma);
    EXPECT_EQ(a.device.lasers, b.device.lasers);
}

TEST(Codec, PulsesKeepEveryBit) {
    const PulseMap map = samples::pulse_map(40, 30);
    const PulseBand b = round_trip(PulseBand{map, 0, 30});
    EXPECT_EQ(b.map.cell_begin, map.cell_begin);
    ASSERT_EQ(b.map.pulses.size(), map.pulses.size());
    for (std::size_t i = 0; i < map.pulses.size(); ++i) {
        const Pulse &x = map.pulses[i], &y = b.map.pulses[i];
        ASSERT_EQ(std::tie(x.u, x.v, x.t_ns, x.s, x.ds_dt, x.amplitude, x.width, x.background,
                           x.sigma, x.chi_square, x.flags, x.laser_id, x.exposure_index),
                  std::tie(y.u, y.v, y.t_ns, y.s, y.ds_dt, y.amplitude, y.width, y.background,
                           y.sigma, y.chi_square, y.flags, y.laser_id, y.exposure_index));
    }
}

TEST(Codec, SmallMessagesKeepEveryField) {
    EXPECT_EQ(round_trip(samples::health()), samples::health());
    EXPECT_EQ(round_trip(samples::end()), samples::end());
    EXPECT_EQ(round_trip(samples::path_table()), samples::path_table());
    const Request request = round_trip(samples::request());
    EXPECT_EQ(request.value, samples::request().value);
    EXPECT_EQ(request.credit_bytes, samples::request().credit_bytes);
    EXPECT_EQ(request.channels, 3);
    ASSERT_TRUE(request.plan);
    EXPECT_FALSE(request.paths);
    EXPECT_EQ(round_trip(samples::paths_request()).paths, samples::path_table());
    const Response response = round_trip(samples::response());
    EXPECT_EQ(response.features, samples::features());
    EXPECT_EQ(response.error, "no");
    ASSERT_TRUE(response.snapshot);
}

TEST(Codec, ARefusedRequestStillTellsItsId) {
    Request request = samples::paths_request();
    request.paths->width_s.push_back(1);
    const Bytes payload = encode(request);
    const auto refused = decode(MessageType::request, payload);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.failure().message.find("request: paths: path column"), std::string::npos)
        << refused.failure().message;
    EXPECT_EQ(request_id(payload), request.id);
    EXPECT_FALSE(request_id(Bytes(20, 0xff)));
}

// A cut payload either fails or, where only padding was cut, still satisfies validate().
TEST(Codec, CutAtEveryByteNeverGivesAnInvalidMessage) {
    for (const Message& message : samples::all()) {
        const Bytes payload = encoded(message);
        for (std::size_t size = 0; size < payload.size(); ++size) {
            const Bytes cut(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(size));
            const auto decoded = decode(type_of(message), cut);
            if (decoded) {
                ASSERT_EQ(complaint_about(*decoded), "");
            }
        }
        EXPECT_FALSE(decode(type_of(message), {}));
    }
}

TEST(Codec, FlippedBitsNeverGiveAnInvalidMessage) {
    for (const Message& message : samples::all()) {
        Bytes payload = encoded(message);
        for (std::size_t bit = 0; bit < 8 * payload.size(); ++bit) {
            const auto mask = static_cast<std::uint8_t>(1U << (bit % 8));
            payload[bit / 8] ^= mask;
            const auto decoded = decode(type_of(message), payload);
            if (decoded) {
                ASSERT_EQ(complaint_about(*decoded), "");
            }
            payload[bit / 8] ^= mask;
        }
    }
}

TEST(Codec, ReadsPayloadsThatAreNotAligned) {
    Bytes shifted = encode(samples::health());
    shifted.insert(shifted.begin(), 0);
    const auto decoded = decode(MessageType::health, std::span(shifted).subspan(1));
    ASSERT_TRUE(decoded);
    EXPECT_EQ(std::get<Health>(*decoded), samples::health());
}

TEST(Codec, RefusesNumbersThatAreNotFinite) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    AxisLog log = samples::axis_log();
    log.samples[2].s = nan;
    EXPECT_FALSE(decode(MessageType::axis_log, encode(log)));
    Request request = samples::request();
    request.value = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(decode(MessageType::request, encode(request)));
    Snapshot snapshot = samples::snapshot();
    snapshot.device.axis_sigma = nan;
    const auto decoded = decode(MessageType::snapshot, encode(snapshot));
    ASSERT_FALSE(decoded);
    EXPECT_NE(decoded.failure().message.find("finite"), std::string::npos);
}

TEST(Codec, RefusesAFrameWhosePixelsAreNotItsSize) {
    Frame frame = samples::frame();
    frame.height = 4;
    EXPECT_FALSE(decode(MessageType::frame, encode(frame)));
    frame.height = 16384;
    frame.width = 16384;
    EXPECT_FALSE(decode(MessageType::frame, encode(frame)));
}

// A foreign writer may put wide elements at any multiple of 4; found by fuzz_message.
TEST(Codec, ReadsNumbersAtAnyAlignment) {
    AxisLog log = samples::axis_log();
    log.sigma_s = 0;  // left out of the bytes, so that only the vectors are moved
    Bytes moved = encode(log);
    moved[0] = static_cast<std::uint8_t>(moved[0] + 4);  // offset of the root, from byte 0
    moved.insert(moved.begin() + 4, 4, 0);
    const auto back = decode(MessageType::axis_log, moved);
    ASSERT_TRUE(back) << back.failure().message;
    ASSERT_EQ(std::get<AxisLog>(*back).samples.size(), log.samples.size());
    EXPECT_EQ(std::get<AxisLog>(*back).samples.back().s, log.samples.back().s);
}

TEST(Compress, KeepsBytesWhetherTheyShrinkOrNot) {
    std::mt19937 rng(1);
    Bytes noise(5000), flat(5000, 7);
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(rng());
    for (const Bytes& bytes : {noise, flat, Bytes{}}) {
        const Packed packed = pack(bytes);
        const auto back =
            unpack(static_cast<std::uint8_t>(packed.compression), packed.bytes, bytes.size());
        ASSERT_TRUE(back);
        EXPECT_EQ(*back, bytes);
    }
    EXPECT_EQ(pack(noise).compression, Compression::none);
    EXPECT_LT(pack(flat).bytes.size(), 100U);
}

TEST(Compress, RefusesAClaimedSizeBeforeTakingMemory) {
    const Packed packed = pack(Bytes(1 << 20, 1));
    const auto back = unpack(1, packed.bytes, 100);
    ASSERT_FALSE(back);
    EXPECT_NE(back.failure().message.find("1048576"), std::string::npos);
    EXPECT_FALSE(unpack(2, packed.bytes, 1 << 20));
    EXPECT_FALSE(unpack(1, Bytes{1, 2, 3}, 3));
}

}  // namespace
}  // namespace stria
