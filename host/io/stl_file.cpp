#include <bit>
#include <cstring>

#include "host/core/errors.h"
#include "host/io/mesh_formats.h"
#include "host/io/ply_writer.h"
#include "host/io/text_lines.h"

namespace stria {
namespace {

constexpr std::size_t kHeaderBytes = 84;  ///< 80 free ones and the count
constexpr std::size_t kFacetBytes = 50;

using Corner = std::array<float, 3>;

/// Gives equal corners (bit by bit, -0 being 0) the same vertex, in order of first appearance.
/// Open addressing; the table is a power of two and at most half full.
class VertexMerger {
  public:
    explicit VertexMerger(TriMesh& mesh) : mesh_(mesh), slots_(1024, kEmpty) {}

    std::uint32_t vertex(Corner corner) {
        for (float& value : corner)
            if (value == 0.0F) value = 0.0F;
        if (2 * corners_.size() >= slots_.size()) grow();
        std::size_t slot = hash(corner) & (slots_.size() - 1);
        while (slots_[slot] != kEmpty) {
            if (corners_[slots_[slot]] == corner) return slots_[slot];
            slot = (slot + 1) & (slots_.size() - 1);
        }
        const auto index = static_cast<std::uint32_t>(corners_.size());
        slots_[slot] = index;
        corners_.push_back(corner);
        mesh_.positions.emplace_back(corner[0], corner[1], corner[2]);
        return index;
    }

  private:
    static constexpr std::uint32_t kEmpty = 0xFFFFFFFF;

    static std::size_t hash(const Corner& corner) {
        std::uint64_t h = 0x9E3779B97F4A7C15ULL;
        for (const float value : corner) {
            h ^= std::bit_cast<std::uint32_t>(value);
            h *= 0xFF51AFD7ED558CCDULL;
            h ^= h >> 32;
        }
        return static_cast<std::size_t>(h);
    }

    void grow() {
        std::vector<std::uint32_t> larger(4 * slots_.size(), kEmpty);
        for (std::uint32_t index = 0; index < corners_.size(); ++index) {
            std::size_t slot = hash(corners_[index]) & (larger.size() - 1);
            while (larger[slot] != kEmpty) slot = (slot + 1) & (larger.size() - 1);
            larger[slot] = index;
        }
        slots_ = std::move(larger);
    }

    TriMesh& mesh_;
    std::vector<Corner> corners_;
    std::vector<std::uint32_t> slots_;
};

std::uint32_t load_count(std::string_view bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t k = 4; k-- > 0;) value = value << 8 | static_cast<std::uint8_t>(bytes[at + k]);
    return value;
}

float load_float(std::string_view bytes, std::size_t at) {
    return std::bit_cast<float>(load_count(bytes, at));
}

/// True if the file is a row of binary solids: header, count, facets, next header ...
bool is_binary(std::string_view bytes) {
    std::size_t at = 0;
    while (bytes.size() - at >= kHeaderBytes) {
        const std::size_t size = kHeaderBytes + kFacetBytes * load_count(bytes, at + 80);
        if (size > bytes.size() - at) return false;
        at += size;
    }
    return at == bytes.size() && at > 0;
}

void parse_binary(std::string_view bytes, const std::string& name, TriMesh& mesh) {
    VertexMerger merger(mesh);
    std::size_t at = 0;
    while (at < bytes.size()) {
        const std::size_t count = load_count(bytes, at + 80);
        at += kHeaderBytes;
        mesh.triangles.reserve(mesh.triangles.size() + count);
        for (std::size_t facet = 0; facet < count; ++facet, at += kFacetBytes) {
            std::array<std::uint32_t, 3> triangle{};
            for (std::size_t k = 0; k < 3; ++k) {
                Corner corner;
                for (std::size_t i = 0; i < 3; ++i) {
                    const std::size_t place = at + 12 + 12 * k + 4 * i;
                    corner[i] = load_float(bytes, place);
                    if (!std::isfinite(corner[i]))
                        throw FileError(
                            name, "byte " + std::to_string(place),
                            "facet " + std::to_string(facet) + ": expected finite coordinates");
                }
                triangle[k] = merger.vertex(corner);
            }
            mesh.triangles.push_back(triangle);
        }
    }
}

/// The keyword in lower case, at most 8 letters of it.
std::string keyword_of(TextLines& lines) {
    std::string word(lines.word().substr(0, 9));
    for (char& c : word)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return word;
}

void parse_ascii(std::string_view bytes, const std::string& name, TriMesh& mesh) {
    VertexMerger merger(mesh);
    TextLines lines(bytes, name);
    std::array<std::uint32_t, 3> triangle{};
    std::size_t corners = 0;
    bool in_facet = false;
    while (lines.next()) {
        const std::string word = keyword_of(lines);
        if (word == "vertex") {
            if (!in_facet || corners == 3)
                lines.fail(in_facet ? "a facet has more than 3 vertices"
                                    : "a vertex stands outside a facet");
            Corner corner;
            for (float& value : corner)
                value = static_cast<float>(lines.finite_number("a vertex' coordinate"));
            if (!std::isfinite(corner[0] + corner[1] + corner[2]))
                lines.fail("expected coordinates within the range of float");
            triangle[corners++] = merger.vertex(corner);
        } else if (word == "facet") {
            if (in_facet) lines.fail("expected 'endfacet' before the next facet");
            in_facet = true;
            corners = 0;
        } else if (word == "endfacet") {
            if (!in_facet || corners != 3)
                lines.fail("expected a facet of 3 vertices, found " + std::to_string(corners));
            mesh.triangles.push_back(triangle);
            in_facet = false;
        } else if (word == "solid" || word == "endsolid") {
            if (in_facet) lines.fail("expected 'endfacet' before '" + word + "'");
        } else if (!word.empty() && word != "outer" && word != "endloop") {
            lines.fail("expected a line of an ascii STL, found '" + shown(lines.line()) + "'");
        }
    }
    if (in_facet) lines.fail("the file ends inside a facet");
}

bool starts_with_solid(std::string_view text) {
    TextLines lines(text.substr(0, 4096), "");
    while (lines.next())
        if (const std::string word = keyword_of(lines); !word.empty()) return word == "solid";
    return false;
}

}  // namespace

TriMesh parse_stl(std::string_view bytes, const std::string& name) {
    TriMesh mesh;
    if (is_binary(bytes)) {
        parse_binary(bytes, name, mesh);
        return mesh;
    }
    const std::string_view text = bytes.size() >= 2 ? bytes : std::string_view{};
    if (starts_with_solid(text)) {
        parse_ascii(plain_text(text, name), name, mesh);
        return mesh;
    }
    if (bytes.size() < kHeaderBytes)
        throw FileError(name, "byte 0",
                        "expected 'solid' or a binary STL of at least 84 bytes, found " +
                            std::to_string(bytes.size()) + " bytes");
    const std::uint64_t expected =
        kHeaderBytes + std::uint64_t{kFacetBytes} * load_count(bytes, 80);
    throw FileError(name, "byte 80",
                    "a binary STL of " + std::to_string(load_count(bytes, 80)) +
                        " facets: expected " + std::to_string(expected) + " bytes, found " +
                        std::to_string(bytes.size()));
}

std::string format_stl(const TriMesh& mesh) {
    std::string bytes = "stria " STRIA_VERSION " binary STL, unit mm";
    bytes.resize(80, ' ');
    bytes.reserve(kHeaderBytes + kFacetBytes * mesh.triangles.size());
    LittleEndianBytes out(bytes);
    out.put(static_cast<std::uint32_t>(mesh.triangles.size()));
    for (const auto& triangle : mesh.triangles) {
        const Eigen::Vector3d& a = mesh.positions[triangle[0]];
        const Eigen::Vector3d& b = mesh.positions[triangle[1]];
        const Eigen::Vector3d& c = mesh.positions[triangle[2]];
        const Eigen::Vector3d ab = b - a, ac = c - a;
        const Eigen::Vector3d normal(ab.y() * ac.z() - ab.z() * ac.y(),
                                     ab.z() * ac.x() - ab.x() * ac.z(),
                                     ab.x() * ac.y() - ab.y() * ac.x());
        const double length = normal.norm();
        for (int k = 0; k < 3; ++k) out.put_float(length > 0 ? normal[k] / length : 0.0);
        for (const std::uint32_t corner : triangle)
            for (int k = 0; k < 3; ++k) out.put_float(mesh.positions[corner][k]);
        out.put(std::uint16_t{0});
    }
    return bytes;
}

}  // namespace stria
