#pragma once
#include <bit>
#include <cstring>
#include <optional>
#include <span>
#include <string>

#include "firmware/protocol/codec.h"
#include "firmware/protocol/wire_generated.h"

/// What the .cpp files that know FlatBuffers share. Included by them alone.
namespace stria::wire_format {

using Builder = flatbuffers::FlatBufferBuilder;

Bytes finished(Builder& builder);

inline std::string text_of(const flatbuffers::String* text) {
    return text != nullptr ? text->str() : std::string();
}

/// The verified root of a payload, or nullptr. The payload must be aligned to 16 bytes.
template <typename Table>
const Table* verified_root(std::span<const std::uint8_t> payload) {
    constexpr flatbuffers::uoffset_t kMaxDepth = 8;
    constexpr flatbuffers::uoffset_t kMaxTables = 4096;
    if (payload.size() < 8) return nullptr;
    flatbuffers::Verifier verifier(payload.data(), payload.size(), kMaxDepth, kMaxTables);
    if (!verifier.VerifyBuffer<Table>(nullptr)) return nullptr;
    return flatbuffers::GetRoot<Table>(payload.data());
}

/// The elements of a vector of numbers. Copied as bytes: FlatBuffers' verifier leaves open whether
/// elements wider than 4 bytes are aligned.
template <typename T>
std::vector<T> vector_of(const flatbuffers::Vector<T>* values) {
    static_assert(std::endian::native == std::endian::little, "the wire is little-endian");
    if (values == nullptr || values->size() == 0) return {};
    std::vector<T> copy(values->size());
    std::memcpy(copy.data(), values->Data(), copy.size() * sizeof(T));
    return copy;
}

Result<Message> decode_snapshot(std::span<const std::uint8_t> payload);
Result<Message> decode_frame(std::span<const std::uint8_t> payload);
Result<Message> decode_axis_log(std::span<const std::uint8_t> payload);
Result<Message> decode_pulse_band(std::span<const std::uint8_t> payload);
Result<Message> decode_path_table(std::span<const std::uint8_t> payload);
Result<Message> decode_health(std::span<const std::uint8_t> payload);
Result<Message> decode_end(std::span<const std::uint8_t> payload);
Result<Message> decode_request(std::span<const std::uint8_t> payload);
Result<Message> decode_response(std::span<const std::uint8_t> payload);

inline Failure malformed(const char* what) {
    return {std::string(what) + ": not a well-formed message (FlatBuffers verifier)"};
}

/// The message, or validate()'s complaint with the kind of message before it.
template <typename T>
Result<Message> checked(const char* what, T message, const std::string& complaint) {
    if (!complaint.empty()) return Failure{std::string(what) + ": " + complaint};
    return Message(std::move(message));
}

// Parts that several messages share (codec_snapshot.cpp).
flatbuffers::Offset<wire::FeatureValue> put(Builder& builder, const FeatureValue& value);
flatbuffers::Offset<wire::Feature> put(Builder& builder, const Feature& feature);
flatbuffers::Offset<wire::Plan> put(Builder& builder, const ScanPlan& plan);
flatbuffers::Offset<wire::Snapshot> put(Builder& builder, const Snapshot& snapshot);
flatbuffers::Offset<wire::PathTable> put(Builder& builder, const PathTable& table);
FeatureValue get(const wire::FeatureValue* value);
Feature get(const wire::Feature& feature);
std::optional<ScanPlan> get(const wire::Plan* plan);
Snapshot get(const wire::Snapshot& snapshot);
std::optional<PathTable> get(const wire::PathTable* table);  // codec_data.cpp
template <typename List>
std::vector<Feature> get_features(const List* list) {
    std::vector<Feature> features;
    if (list == nullptr) return features;
    for (const wire::Feature* feature : *list) features.push_back(get(*feature));
    return features;
}

}  // namespace stria::wire_format
