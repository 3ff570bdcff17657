#include "firmware/protocol/validate.h"
#include "firmware/protocol/wire.h"

namespace stria {
namespace wire_format {

Result<Message> decode_health(std::span<const std::uint8_t> payload) {
    const auto* root = verified_root<wire::Health>(payload);
    if (root == nullptr) return malformed("health");
    Health health{root->t_ns(),           static_cast<DeviceState>(root->state()),
                  root->laser_on(),       root->interlock_closed(),
                  root->emission_s(),     root->frames(),
                  root->frames_dropped(), text_of(root->message())};
    const std::string complaint = validate(health);
    return checked("health", std::move(health), complaint);
}

Result<Message> decode_end(std::span<const std::uint8_t> payload) {
    const auto* root = verified_root<wire::End>(payload);
    if (root == nullptr) return malformed("end");
    End end{root->complete(), text_of(root->reason()), root->frames(), root->frames_dropped(),
            root->emission_s()};
    const std::string complaint = validate(end);
    return checked("end", std::move(end), complaint);
}

Result<Message> decode_request(std::span<const std::uint8_t> payload) {
    const auto* root = verified_root<wire::Request>(payload);
    if (root == nullptr) return malformed("request");
    Request request;
    request.id = root->id();
    request.verb = static_cast<RequestVerb>(root->verb());
    request.client = text_of(root->client());
    request.role = static_cast<Role>(root->role());
    request.name = text_of(root->name());
    request.value = get(root->value());
    request.plan = get(root->plan());
    request.credit_bytes = root->credit_bytes();
    request.run = root->run();
    request.channels = root->channels();
    request.paths = get(root->paths());
    const std::string complaint = validate(request);
    return checked("request", std::move(request), complaint);
}

Result<Message> decode_response(std::span<const std::uint8_t> payload) {
    const auto* root = verified_root<wire::Response>(payload);
    if (root == nullptr) return malformed("response");
    Response response;
    response.id = root->id();
    response.ok = root->ok();
    response.error = text_of(root->error());
    response.role = static_cast<Role>(root->role());
    response.run = root->run();
    if (root->snapshot() != nullptr) response.snapshot = get(*root->snapshot());
    response.features = get_features(root->features());
    const std::string complaint = validate(response);
    return checked("response", std::move(response), complaint);
}

}  // namespace wire_format

Bytes encode(const Health& h) {
    wire_format::Builder b;
    const auto message = b.CreateString(h.message);
    b.Finish(wire::CreateHealth(b, h.t_ns, static_cast<std::uint8_t>(h.state), h.laser_on,
                                h.interlock_closed, h.emission_s, h.frames, h.frames_dropped,
                                message));
    return wire_format::finished(b);
}

Bytes encode(const End& end) {
    wire_format::Builder b;
    const auto reason = b.CreateString(end.reason);
    b.Finish(
        wire::CreateEnd(b, end.complete, reason, end.frames, end.frames_dropped, end.emission_s));
    return wire_format::finished(b);
}

Bytes encode(const Request& r) {
    wire_format::Builder b;
    const auto client = b.CreateString(r.client);
    const auto name = b.CreateString(r.name);
    const auto value = wire_format::put(b, r.value);
    const auto plan = r.plan ? wire_format::put(b, *r.plan) : flatbuffers::Offset<wire::Plan>();
    const auto paths =
        r.paths ? wire_format::put(b, *r.paths) : flatbuffers::Offset<wire::PathTable>();
    b.Finish(wire::CreateRequest(b, r.id, static_cast<std::uint8_t>(r.verb), client,
                                 static_cast<std::uint8_t>(r.role), name, value, plan,
                                 r.credit_bytes, r.run, r.channels, paths));
    return wire_format::finished(b);
}

std::optional<std::uint32_t> request_id(std::span<const std::uint8_t> payload) {
    const Bytes aligned(payload.begin(), payload.end());
    const auto* root = wire_format::verified_root<wire::Request>(aligned);
    if (root == nullptr) return std::nullopt;
    return root->id();
}

Bytes encode(const Response& r) {
    wire_format::Builder b;
    const auto error = b.CreateString(r.error);
    const auto snapshot =
        r.snapshot ? wire_format::put(b, *r.snapshot) : flatbuffers::Offset<wire::Snapshot>();
    std::vector<flatbuffers::Offset<wire::Feature>> list;
    for (const Feature& feature : r.features) list.push_back(wire_format::put(b, feature));
    const auto features = b.CreateVector(list);
    b.Finish(wire::CreateResponse(b, r.id, r.ok, error, static_cast<std::uint8_t>(r.role), r.run,
                                  snapshot, features));
    return wire_format::finished(b);
}

}  // namespace stria
