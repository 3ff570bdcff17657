#include "firmware/protocol/compress.h"
#include "firmware/protocol/validate.h"
#include "firmware/protocol/wire.h"

namespace stria {
namespace wire_format {

Result<Message> decode_frame(std::span<const std::uint8_t> payload) {
    const auto* root = verified_root<wire::Frame>(payload);
    if (root == nullptr || root->pixels() == nullptr) return malformed("frame");
    Frame f;
    f.width = root->width();
    f.height = root->height();
    f.bits = root->bits();
    if (f.width < 1 || f.width > kMaxFrameSide || f.height < 1 || f.height > kMaxFrameSide ||
        f.bits < 8 || f.bits > 16)
        return checked("frame", std::move(f), validate(f));
    const std::size_t size = static_cast<std::size_t>(f.width) *
                             static_cast<std::size_t>(f.height) *
                             static_cast<std::size_t>(f.bytes_per_sample());
    if (size > kMaxPayloadBytes) return Failure{"frame: expected at most 64 MiB of pixels"};
    auto pixels =
        unpack(root->compression(), {root->pixels()->data(), root->pixels()->size()}, size);
    if (!pixels) return Failure{"frame: " + pixels.failure().message};
    f.bytes = std::move(*pixels);
    f.camera_id = root->camera_id();
    f.laser_id = root->laser_id();
    f.exposure_index = root->exposure_index();
    f.laser_power = root->laser_power();
    f.exposure_start_ns = root->exposure_start_ns();
    f.exposure_ns = root->exposure_ns();
    f.row_time_ns = root->row_time_ns();
    f.sequence = root->sequence();
    const std::string complaint = validate(f);
    return checked("frame", std::move(f), complaint);
}

Result<Message> decode_axis_log(std::span<const std::uint8_t> payload) {
    const auto* root = verified_root<wire::AxisLog>(payload);
    if (root == nullptr) return malformed("axis log");
    const std::vector<TimeNs> times = vector_of(root->t_ns());
    const std::vector<double> positions = vector_of(root->s());
    if (times.size() != positions.size())
        return Failure{"axis log: expected as many positions as times"};
    AxisLog log;
    log.sigma_s = root->sigma_s();
    log.samples.reserve(times.size());
    for (std::size_t i = 0; i < times.size(); ++i) log.samples.push_back({times[i], positions[i]});
    const std::string complaint = validate(log);
    return checked("axis log", std::move(log), complaint);
}

std::optional<PathTable> get(const wire::PathTable* w) {
    if (w == nullptr) return std::nullopt;
    PathTable t;
    t.camera_id = w->camera_id();
    t.laser_id = w->laser_id();
    t.image_width = w->image_width();
    t.image_height = w->image_height();
    t.nodes_x = w->nodes_x();
    t.nodes_y = w->nodes_y();
    t.model_hash = text_of(w->model_hash());
    t.du_ds = vector_of(w->du_ds());
    t.dv_ds = vector_of(w->dv_ds());
    t.d2u_ds2 = vector_of(w->d2u_ds2());
    t.d2v_ds2 = vector_of(w->d2v_ds2());
    t.width_s = vector_of(w->width_s());
    t.valid = vector_of(w->valid());
    return t;
}

flatbuffers::Offset<wire::PathTable> put(Builder& b, const PathTable& t) {
    const auto hash = b.CreateString(t.model_hash);
    const auto du = b.CreateVector(t.du_ds);
    const auto dv = b.CreateVector(t.dv_ds);
    const auto d2u = b.CreateVector(t.d2u_ds2);
    const auto d2v = b.CreateVector(t.d2v_ds2);
    const auto width = b.CreateVector(t.width_s);
    const auto valid = b.CreateVector(t.valid);
    return wire::CreatePathTable(b, t.camera_id, t.laser_id, t.image_width, t.image_height,
                                 t.nodes_x, t.nodes_y, hash, du, dv, d2u, d2v, width, valid);
}

Result<Message> decode_path_table(std::span<const std::uint8_t> payload) {
    const auto* root = verified_root<wire::PathTable>(payload);
    if (root == nullptr) return malformed("path table");
    PathTable table = *get(root);
    const std::string complaint = validate(table);
    return checked("path table", std::move(table), complaint);
}

}  // namespace wire_format

Bytes encode(const Frame& f) {
    const Packed packed = pack(f.bytes);
    wire_format::Builder b(packed.bytes.size() + 256);
    const auto pixels = b.CreateVector(packed.bytes);
    b.Finish(wire::CreateFrame(b, f.camera_id, f.laser_id, f.exposure_index, f.width, f.height,
                               f.bits, f.laser_power, f.exposure_start_ns, f.exposure_ns,
                               f.row_time_ns, f.sequence,
                               static_cast<std::uint8_t>(packed.compression), pixels));
    return wire_format::finished(b);
}

Bytes encode(const AxisLog& log) {
    std::vector<std::int64_t> times;
    std::vector<double> positions;
    for (const AxisSample& sample : log.samples) {
        times.push_back(sample.t_ns);
        positions.push_back(sample.s);
    }
    wire_format::Builder b(16 * log.samples.size() + 256);
    const auto t = b.CreateVector(times);
    const auto s = b.CreateVector(positions);
    b.Finish(wire::CreateAxisLog(b, log.sigma_s, t, s));
    return wire_format::finished(b);
}

Bytes encode(const PathTable& table) {
    wire_format::Builder builder;
    builder.Finish(wire_format::put(builder, table));
    return wire_format::finished(builder);
}

}  // namespace stria
