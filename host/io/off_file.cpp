#include <algorithm>

#include "host/core/errors.h"
#include "host/io/mesh_formats.h"
#include "host/io/number_text.h"
#include "host/io/text_lines.h"

namespace stria {
namespace {

/// Goes to the next line that says something; comments begin with '#'.
bool next_line(TextLines& lines) {
    while (lines.next()) {
        const std::string_view rest = lines.rest();
        if (!rest.empty() && rest[0] != '#') return true;
    }
    return false;
}

/// What the keyword's prefix letters say a vertex line holds after its position.
struct OffKind {
    bool texture = false, colour = false, normal = false;
};

/// The keyword; the first count may follow it without a blank.
OffKind read_keyword(TextLines& lines) {
    const std::string_view rest = lines.rest();
    const std::size_t end = rest.find("OFF");
    std::string_view prefix = rest.substr(0, std::min(end, rest.size()));
    OffKind kind;
    const auto take = [&](std::string_view letters) {
        const bool has = prefix.starts_with(letters);
        if (has) prefix.remove_prefix(letters.size());
        return has;
    };
    kind.texture = take("ST");
    kind.colour = take("C");
    kind.normal = take("N");
    if (end == std::string_view::npos || !prefix.empty())
        lines.fail("expected 'OFF' (or STOFF, COFF, NOFF), found '" + shown(lines.line()) + "'");
    lines.skip(end + 3);
    return kind;
}

class OffReader {
  public:
    OffReader(std::string_view text, const std::string& name) : lines_(text, name), name_(name) {}

    TriMesh read() {
        if (!next_line(lines_)) throw FileError(name_, "line 1", "expected 'OFF', found nothing");
        const OffKind kind = read_keyword(lines_);
        if (const std::string_view rest = lines_.rest(); rest.starts_with("BINARY"))
            lines_.fail("expected ascii OFF, found a binary one");
        if (lines_.rest().empty() || lines_.rest()[0] == '#') expect_line("the three counts");
        const std::size_t vertices = read_count("the number of vertices", 6);
        const std::size_t faces = read_count("the number of faces", 2);
        TriMesh mesh;
        mesh.positions.reserve(vertices);
        if (kind.normal) mesh.attributes.push_back({"normal", 3, {}});
        if (kind.colour) mesh.attributes.push_back({"colour", 3, {}});
        for (std::size_t i = 0; i < vertices; ++i) read_vertex(kind, mesh);
        for (std::size_t i = 0; i < faces; ++i) read_face(mesh);
        return mesh;
    }

  private:
    void expect_line(const char* what) {
        if (!next_line(lines_))
            lines_.fail(std::string("expected ") + what + ", found the end of the file");
    }

    /// A count that the bytes left can hold, at `least` bytes each.
    std::size_t read_count(const char* what, std::size_t least) {
        const std::int64_t count = lines_.integer(what);
        if (count < 0 || static_cast<std::uint64_t>(count) > (lines_.left() + least) / least)
            lines_.fail(std::string("expected ") + what + ", at most what the file's " +
                        std::to_string(lines_.left()) + " bytes can hold, found " +
                        std::to_string(count));
        return static_cast<std::size_t>(count);
    }

    void read_vertex(const OffKind& kind, TriMesh& mesh) {
        expect_line("a vertex");
        Eigen::Vector3d position;
        for (int k = 0; k < 3; ++k) position[k] = lines_.finite_number("a vertex' coordinate");
        mesh.positions.push_back(position);
        if (VertexAttribute* normal = mesh.find_attribute("normal"))
            for (int k = 0; k < 3; ++k)
                normal->values.push_back(
                    static_cast<float>(lines_.number("a normal's coordinate")));
        if (kind.colour) read_colour(*mesh.find_attribute("colour"));
    }

    /// Whole numbers are of 0 to 255, numbers with a point of 0 to 1.
    void read_colour(VertexAttribute& colour) {
        for (int k = 0; k < 3; ++k) {
            TextLines peek = lines_;
            const bool whole = peek.word().find_first_of(".eE") == std::string_view::npos;
            const double value = lines_.number("a colour");
            colour.values.push_back(static_cast<float>(whole ? value / 255.0 : value));
        }
    }

    void read_face(TriMesh& mesh) {
        expect_line("a face");
        const std::int64_t corners = lines_.integer("a face's number of corners");
        if (corners < 0) lines_.fail("expected a face's number of corners, found a negative one");
        const auto vertices = static_cast<std::int64_t>(mesh.positions.size());
        std::uint32_t first = 0, last = 0;
        for (std::int64_t i = 0; i < corners; ++i) {
            const std::int64_t index = lines_.integer("a vertex index");
            if (index < 0 || index >= vertices)
                lines_.fail("expected a vertex index of 0 to " + std::to_string(vertices - 1) +
                            ", found " + std::to_string(index));
            const auto corner = static_cast<std::uint32_t>(index);
            if (i == 0) first = corner;
            if (i >= 2) mesh.triangles.push_back({first, last, corner});
            last = corner;
        }
    }

    TextLines lines_;
    std::string name_;
};

}  // namespace

TriMesh parse_off(std::string_view bytes, const std::string& name) {
    return OffReader(plain_text(bytes, name), name).read();
}

std::string format_off(const TriMesh& mesh) {
    std::string text = "OFF\n" + std::to_string(mesh.positions.size()) + " " +
                       std::to_string(mesh.triangles.size()) + " 0\n";
    for (const Eigen::Vector3d& position : mesh.positions) {
        for (int k = 0; k < 3; ++k) {
            append_number(text, position[k]);
            text += k < 2 ? ' ' : '\n';
        }
    }
    for (const auto& triangle : mesh.triangles) {
        text += '3';
        for (const std::uint32_t corner : triangle) {
            text += ' ';
            append_number(text, std::int64_t{corner});
        }
        text += '\n';
    }
    return text;
}

}  // namespace stria
