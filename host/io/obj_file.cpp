#include <cmath>
#include <limits>

#include "host/core/errors.h"
#include "host/io/mesh_formats.h"
#include "host/io/number_text.h"
#include "host/io/text_lines.h"

namespace stria {
namespace {

/// What has been read so far. Normals stand at corners in OBJ; a vertex gets the mean of those at
/// its corners.
class ObjReader {
  public:
    ObjReader(std::string_view text, const std::string& name) : lines_(text, name) {}

    TriMesh read() {
        while (lines_.next()) {
            statement_ = lines_.line();
            if (!statement_.empty() && statement_.back() == '\\') join_lines();
            read_statement();
        }
        TriMesh mesh;
        mesh.positions = std::move(positions_);
        mesh.triangles = std::move(triangles_);
        add_attributes(mesh);
        return mesh;
    }

  private:
    std::string_view word() {
        std::size_t begin = 0;
        while (begin < statement_.size() && is_blank(statement_[begin])) ++begin;
        std::size_t end = begin;
        while (end < statement_.size() && !is_blank(statement_[end])) ++end;
        const std::string_view result = statement_.substr(begin, end - begin);
        statement_.remove_prefix(end);
        return result;
    }
    static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

    /// A backslash at the end continues the statement on the next line.
    void join_lines() {
        joined_.assign(statement_);
        while (!joined_.empty() && joined_.back() == '\\') {
            joined_.back() = ' ';
            if (!lines_.next()) break;
            joined_ += lines_.line();
        }
        statement_ = joined_;
    }

    void read_statement() {
        const std::string_view keyword = word();
        if (keyword == "v")
            read_vertex();
        else if (keyword == "vn")
            normals_.push_back(read_vector("a normal's coordinate"));
        else if (keyword == "vt")
            ++texture_count_;
        else if (keyword == "f" || keyword == "fo")
            read_face();
        // Everything else (groups, materials, lines, curves) does not change the triangles.
    }

    double number(const char* what) {
        const std::string_view found = word();
        const auto value = parse_number(found);
        if (!value)
            lines_.fail(
                std::string("expected ") + what +
                (found.empty() ? ", found the end of the line" : ", found '" + shown(found) + "'"));
        return *value;
    }

    Eigen::Vector3d read_vector(const char* what) {
        Eigen::Vector3d value;
        for (int k = 0; k < 3; ++k) value[k] = number(what);
        return value;
    }

    /// x y z, x y z w, x y z r g b or x y z w r g b.
    void read_vertex() {
        const Eigen::Vector3d position = read_vector("a vertex' coordinate");
        if (!position.allFinite()) lines_.fail("expected finite coordinates");
        double more[4];
        int count = 0;
        for (std::string_view next = word(); !next.empty() && next[0] != '#' && count < 4;
             next = word()) {
            const auto value = parse_number(next);
            if (!value) lines_.fail("expected a number, found '" + shown(next) + "'");
            more[count++] = *value;
        }
        positions_.push_back(position);
        if (count < 3) return;
        colours_.resize(3 * (positions_.size() - 1), 1.0F);  // white where none was given
        for (int k = count - 3; k < count; ++k) colours_.push_back(static_cast<float>(more[k]));
    }

    /// The element that a positive (from 1) or negative (from the end) OBJ index means.
    std::uint32_t resolve(std::string_view text, std::size_t count, const char* what) {
        const auto index = parse_integer(text);
        const auto size = static_cast<std::int64_t>(count);
        if (!index || *index == 0 || *index > size || *index < -size)
            lines_.fail(std::string("expected the index of a ") + what + ", 1 to " +
                        std::to_string(size) + " or negative, found '" + shown(text) + "'");
        return static_cast<std::uint32_t>(*index > 0 ? *index - 1 : size + *index);
    }

    std::uint32_t read_corner(std::string_view text) {
        const std::size_t slash = text.find('/');
        const std::uint32_t vertex = resolve(text.substr(0, slash), positions_.size(), "vertex");
        if (slash == std::string_view::npos) return vertex;
        std::string_view rest = text.substr(slash + 1);
        const std::size_t second = rest.find('/');
        const std::string_view texture = rest.substr(0, second);
        if (!texture.empty()) resolve(texture, texture_count_, "texture vertex");
        if (second == std::string_view::npos || second + 1 == rest.size()) return vertex;
        const std::uint32_t normal = resolve(rest.substr(second + 1), normals_.size(), "normal");
        if (sums_.size() < positions_.size())
            sums_.resize(positions_.size(), Eigen::Vector3d::Zero());
        sums_[vertex] += normals_[normal];
        return vertex;
    }

    void read_face() {
        std::uint32_t first = 0, last = 0;
        std::size_t corners = 0;
        for (std::string_view next = word(); !next.empty() && next[0] != '#'; next = word()) {
            const std::uint32_t corner = read_corner(next);
            if (corners == 0) first = corner;
            if (corners >= 2) triangles_.push_back({first, last, corner});
            last = corner;
            ++corners;
        }
        if (corners < 3)
            lines_.fail("expected a face of at least 3 corners, found " + std::to_string(corners));
    }

    void add_attributes(TriMesh& mesh) {
        if (!sums_.empty()) {
            sums_.resize(mesh.positions.size(), Eigen::Vector3d::Zero());
            VertexAttribute normal{"normal", 3, {}};
            normal.values.reserve(3 * sums_.size());
            for (const Eigen::Vector3d& sum : sums_)
                for (int k = 0; k < 3; ++k)
                    normal.values.push_back(static_cast<float>(sum.normalized()[k]));
            mesh.attributes.push_back(std::move(normal));
        }
        if (!colours_.empty()) {
            colours_.resize(3 * mesh.positions.size(), 1.0F);
            mesh.attributes.push_back({"colour", 3, std::move(colours_)});
        }
    }

    TextLines lines_;
    std::string_view statement_;
    std::string joined_;
    std::vector<Eigen::Vector3d> positions_, normals_, sums_;
    std::vector<float> colours_;
    std::vector<std::array<std::uint32_t, 3>> triangles_;
    std::size_t texture_count_ = 0;
};

}  // namespace

std::string_view plain_text(std::string_view bytes, const std::string& name) {
    const auto starts = [&](std::string_view mark) { return bytes.substr(0, mark.size()) == mark; };
    const bool wide = starts("\xFF\xFE") || starts("\xFE\xFF") ||
                      (bytes.size() >= 2 && (bytes[0] == '\0') != (bytes[1] == '\0'));
    if (wide)
        throw FileError(name, "byte 0",
                        "expected plain text (ASCII or UTF-8), found UTF-16 or UTF-32; save it as "
                        "UTF-8");
    if (starts("\xEF\xBB\xBF")) bytes.remove_prefix(3);
    return bytes;
}

TriMesh parse_obj(std::string_view bytes, const std::string& name) {
    return ObjReader(plain_text(bytes, name), name).read();
}

std::string format_obj(const TriMesh& mesh) {
    const VertexAttribute* normal = mesh.find_attribute("normal");
    const VertexAttribute* colour = mesh.find_attribute("colour");
    if (normal && normal->components != 3) normal = nullptr;
    if (colour && colour->components != 3) colour = nullptr;
    std::string text = "# stria " STRIA_VERSION "\n";
    text.reserve(40 * mesh.positions.size() + 24 * mesh.triangles.size());
    const auto put_three = [&](const VertexAttribute& attribute, std::size_t i) {
        for (std::size_t k = 0; k < 3; ++k) {
            text += ' ';
            const float value = attribute.values[3 * i + k];
            append_number(text, std::isfinite(value) ? value : 0.0F);
        }
    };
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        text += 'v';
        for (int k = 0; k < 3; ++k) {
            text += ' ';
            append_number(text, mesh.positions[i][k]);
        }
        if (colour) put_three(*colour, i);
        text += '\n';
    }
    for (std::size_t i = 0; normal && i < mesh.positions.size(); ++i) {
        text += "vn";
        put_three(*normal, i);
        text += '\n';
    }
    for (const auto& triangle : mesh.triangles) {
        text += 'f';
        for (const std::uint32_t corner : triangle) {
            text += ' ';
            append_number(text, std::int64_t{corner} + 1);
            if (!normal) continue;
            text += "//";
            append_number(text, std::int64_t{corner} + 1);
        }
        text += '\n';
    }
    return text;
}

}  // namespace stria
