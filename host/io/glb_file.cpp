#include <algorithm>
#include <cmath>

#include "host/io/mesh_formats.h"
#include "host/io/number_text.h"
#include "host/io/ply_writer.h"

// glTF 2.0, chapter 4 "GLB file format": one JSON chunk, one binary chunk, one mesh. glTF's unit is
// the metre and its y points up; positions stay in mm and the node scales them by 0.001.
namespace stria {
namespace {

constexpr std::uint32_t kMagic = 0x46546C67, kJson = 0x4E4F534A, kBin = 0x004E4942;

/// Accessors and buffer views of one binary chunk.
class GlbBuffer {
  public:
    GlbBuffer() : out_(bytes_) {}

    /// Floats, three a vertex; values that are not finite become 0. Returns the accessor's index.
    template <typename Value>
    int add_vectors(std::size_t count, const std::string& bounds, const Value& value) {
        begin(34962, count * 12);
        for (std::size_t i = 0; i < 3 * count; ++i) {
            const float v = value(i);
            out_.put(std::isfinite(v) ? v : 0.0F);
        }
        return finish(count, 5126, "VEC3", bounds);
    }
    int add_indices(const std::vector<std::array<std::uint32_t, 3>>& triangles) {
        begin(34963, triangles.size() * 12);
        for (const auto& triangle : triangles)
            for (const std::uint32_t corner : triangle) out_.put(corner);
        return finish(3 * triangles.size(), 5125, "SCALAR", "");
    }
    const std::string& bytes() const { return bytes_; }
    std::string json() const {
        return "\"accessors\":[" + accessors_ + "],\"bufferViews\":[" + views_ +
               "],\"buffers\":[{\"byteLength\":" + std::to_string(bytes_.size()) + "}]";
    }

  private:
    void begin(int target, std::size_t length) {
        if (!views_.empty()) views_ += ',';
        views_ += "{\"buffer\":0,\"byteOffset\":" + std::to_string(bytes_.size()) +
                  ",\"byteLength\":" + std::to_string(length) +
                  ",\"target\":" + std::to_string(target) + "}";
        bytes_.reserve(bytes_.size() + length);
    }
    int finish(std::size_t count, int type, const char* shape, const std::string& bounds) {
        if (!accessors_.empty()) accessors_ += ',';
        accessors_ += "{\"bufferView\":" + std::to_string(next_) +
                      ",\"componentType\":" + std::to_string(type) +
                      ",\"count\":" + std::to_string(count) + ",\"type\":\"" + shape + "\"" +
                      bounds + "}";
        return next_++;
    }

    std::string bytes_, accessors_, views_;
    LittleEndianBytes out_;
    int next_ = 0;
};

/// The least and greatest coordinates, which glTF asks for.
std::string bounds_of(const std::vector<Eigen::Vector3d>& positions) {
    Eigen::Vector3f low = Eigen::Vector3f::Zero(), high = low;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const Eigen::Vector3f p = positions[i].cast<float>();
        low = i ? low.cwiseMin(p).eval() : p;
        high = i ? high.cwiseMax(p).eval() : p;
    }
    const auto list = [](const Eigen::Vector3f& v) {
        std::string text;
        for (int k = 0; k < 3; ++k) {
            if (k) text += ',';
            append_number(text, v[k]);
        }
        return "[" + text + "]";
    };
    return ",\"min\":" + list(low) + ",\"max\":" + list(high);
}

void add_chunk(std::string& file, std::uint32_t type, std::string data, char padding) {
    data.resize((data.size() + 3) / 4 * 4, padding);
    LittleEndianBytes out(file);
    out.put(static_cast<std::uint32_t>(data.size()));
    out.put(type);
    file += data;
}

float unit_component(const std::vector<float>& values, std::size_t i) {
    const float* v = &values[i - i % 3];
    const float length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    return length > 0 ? values[i] / length : (i % 3 == 2 ? 1.0F : 0.0F);
}

}  // namespace

std::string format_glb(const TriMesh& mesh) {
    GlbBuffer buffer;
    std::string content;
    if (!mesh.positions.empty()) {
        const std::size_t count = mesh.positions.size();
        std::string attributes =
            "\"POSITION\":" +
            std::to_string(buffer.add_vectors(count, bounds_of(mesh.positions), [&](std::size_t i) {
                return static_cast<float>(mesh.positions[i / 3][static_cast<int>(i % 3)]);
            }));
        if (const VertexAttribute* normal = mesh.find_attribute("normal");
            normal && normal->components == 3)
            attributes +=
                ",\"NORMAL\":" + std::to_string(buffer.add_vectors(count, "", [&](std::size_t i) {
                    return unit_component(normal->values, i);
                }));
        if (const VertexAttribute* colour = mesh.find_attribute("colour");
            colour && colour->components == 3)
            attributes +=
                ",\"COLOR_0\":" + std::to_string(buffer.add_vectors(count, "", [&](std::size_t i) {
                    return std::clamp(colour->values[i], 0.0F, 1.0F);
                }));
        std::string primitive = "{\"attributes\":{" + attributes + "}";
        if (mesh.triangles.empty())
            primitive += ",\"mode\":0";
        else
            primitive += ",\"indices\":" + std::to_string(buffer.add_indices(mesh.triangles));
        content =
            ",\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"scale\":"
            "[0.001,0.001,0.001]}],\"meshes\":[{\"primitives\":[" +
            primitive + "}]}]," + buffer.json();
    }
    const std::string json = "{\"asset\":{\"version\":\"2.0\",\"generator\":\"stria " STRIA_VERSION
                             "\"}" +
                             content + "}";
    std::string chunks;
    add_chunk(chunks, kJson, json, ' ');
    if (!buffer.bytes().empty()) add_chunk(chunks, kBin, buffer.bytes(), '\0');
    std::string file;
    LittleEndianBytes out(file);
    out.put(kMagic);
    out.put(std::uint32_t{2});
    out.put(static_cast<std::uint32_t>(12 + chunks.size()));
    return file + chunks;
}

}  // namespace stria
