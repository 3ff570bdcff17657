#include <algorithm>
#include <array>
#include <cmath>

#include "host/io/mesh_formats.h"
#include "host/io/number_text.h"

namespace stria {
namespace {

struct Group {
    const char* attribute;
    std::array<const char*, 3> columns;
};
/// Names of the field for the same three numbers.
constexpr Group kGroups[] = {{"normal", {"nx", "ny", "nz"}},
                             {"normal", {"normal_x", "normal_y", "normal_z"}},
                             {"colour", {"red", "green", "blue"}},
                             {"colour", {"diffuse_red", "diffuse_green", "diffuse_blue"}},
                             {"colour", {"r", "g", "b"}}};

NamedColumn* find(std::vector<NamedColumn>& columns, const std::string& name) {
    const auto found = std::find_if(columns.begin(), columns.end(),
                                    [&](const NamedColumn& c) { return c.name == name; });
    return found == columns.end() ? nullptr : &*found;
}

/// Joins the columns into one attribute and empties their names.
VertexAttribute joined(const std::string& name, const std::vector<NamedColumn*>& parts,
                       bool scaled) {
    const std::size_t rows = parts[0]->values.size();
    VertexAttribute attribute{name, static_cast<int>(parts.size()), {}};
    attribute.values.resize(rows * parts.size());
    for (std::size_t k = 0; k < parts.size(); ++k) {
        const double factor = scaled ? 1.0 / parts[k]->scale : 1.0;
        for (std::size_t i = 0; i < rows; ++i)
            attribute.values[i * parts.size() + k] =
                static_cast<float>(parts[k]->values[i] * factor);
        parts[k]->name.clear();
        parts[k]->values = {};
    }
    return attribute;
}

}  // namespace

std::vector<VertexAttribute> attributes_from(std::vector<NamedColumn> columns) {
    std::vector<VertexAttribute> attributes;
    const auto taken = [&](const std::string& name) {
        return std::any_of(attributes.begin(), attributes.end(),
                           [&](const VertexAttribute& a) { return a.name == name; });
    };
    for (const Group& group : kGroups) {
        std::vector<NamedColumn*> parts;
        for (const char* name : group.columns)
            if (NamedColumn* part = find(columns, name)) parts.push_back(part);
        if (parts.size() == 3 && !taken(group.attribute))
            attributes.push_back(
                joined(group.attribute, parts, std::string(group.attribute) == "colour"));
    }
    for (std::size_t i = 0; i < columns.size(); ++i) {
        const std::string name = columns[i].name;
        if (name.empty()) continue;
        const std::string base =
            name.size() > 2 && name.ends_with("_0") ? name.substr(0, name.size() - 2) : "";
        std::vector<NamedColumn*> parts;
        for (int k = 0; !base.empty(); ++k) {
            NamedColumn* part = find(columns, base + "_" + std::to_string(k));
            if (!part) break;
            parts.push_back(part);
        }
        const bool grouped = parts.size() > 1 && !taken(base);
        if (!grouped) parts = {&columns[i]};
        attributes.push_back(joined(grouped ? base : name, parts, false));
    }
    return attributes;
}

std::vector<std::string> component_names(const VertexAttribute& attribute) {
    if (attribute.name == "normal" && attribute.components == 3) return {"nx", "ny", "nz"};
    if (attribute.name == "colour" && attribute.components == 3) return {"red", "green", "blue"};
    std::string base = attribute.name.empty() ? "unnamed" : attribute.name;
    for (char& c : base)
        if (static_cast<unsigned char>(c) <= ' ' || c == ',' || c == ';') c = '_';
    if (attribute.components == 1) return {base};
    std::vector<std::string> names;
    for (int k = 0; k < attribute.components; ++k) names.push_back(base + "_" + std::to_string(k));
    return names;
}

void drop_points_not_finite(PointCloud& cloud) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
        if (!cloud.positions[i].allFinite()) continue;
        cloud.positions[kept] = cloud.positions[i];
        for (VertexAttribute& attribute : cloud.attributes) {
            const auto n = static_cast<std::size_t>(attribute.components);
            std::copy_n(attribute.values.begin() + static_cast<std::ptrdiff_t>(i * n), n,
                        attribute.values.begin() + static_cast<std::ptrdiff_t>(kept * n));
        }
        ++kept;
    }
    cloud.dropped += cloud.positions.size() - kept;
    cloud.positions.resize(kept);
    for (VertexAttribute& attribute : cloud.attributes)
        attribute.values.resize(kept * static_cast<std::size_t>(attribute.components));
}

}  // namespace stria
