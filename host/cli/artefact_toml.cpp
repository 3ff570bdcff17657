#include "host/cli/artefact_toml.h"

#include <algorithm>

#include "host/io/toml_file.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

/// KEY_mm and its uncertainty KEY_u_mm.
CalibratedLength read_length(TomlTable& table, const std::string& key) {
    return {table.number(key + "_mm"), table.number(key + "_u_mm")};
}

std::optional<double> read_optional(TomlTable& table, const std::string& key) {
    if (!table.has(key)) return {};
    return table.number(key);
}

std::optional<Temperature> read_temperature(TomlTable& root) {
    std::optional<TomlTable> table = root.find_table("temperature");
    if (!table) return {};
    Temperature t;
    t.reference_c = table->number("reference_c", t.reference_c);
    t.measured_c = table->number("measured_c");
    t.measured_expanded_c = table->number("measured_u_c");
    t.cte_per_k = table->number("cte_per_k");
    t.cte_expanded_per_k = table->number("cte_u_per_k");
    return t;
}

/// KEYs_mm and KEYs_u_mm, one each.
std::vector<CalibratedLength> read_lengths(TomlTable& table, const std::string& key,
                                           std::size_t count) {
    const std::vector<double> values = table.numbers(key + "_mm", count);
    const std::vector<double> expanded = table.numbers(key + "_u_mm", values.size());
    std::vector<CalibratedLength> lengths;
    for (std::size_t i = 0; i < values.size(); ++i) lengths.push_back({values[i], expanded[i]});
    return lengths;
}

void read_measures(TomlTable& root, const std::string& kind, Artefact& artefact) {
    if (kind == "sphere") artefact.diameters = {read_length(root, "diameter")};
    if (kind == "bar" || kind == "beam") {
        artefact.diameters = read_lengths(root, "diameters", kind == "bar" ? 2 : 0);
        if (artefact.diameters.size() < 2 || artefact.diameters.size() > 20)
            root.refuse("diameters_mm", "expected 2 to 20 spheres, found " +
                                            std::to_string(artefact.diameters.size()));
        artefact.lengths = read_lengths(root, "lengths", artefact.diameters.size() - 1);
    }
    if (kind == "travel") {
        artefact.travelled_mm = root.numbers("travelled_mm");
        artefact.travelled_expanded_mm = root.number("travelled_u_mm");
    }
    if (kind == "plane" || kind == "travel") {
        const std::vector<double> size = root.numbers("size_mm", 2);
        artefact.size_mm = {std::max(size[0], size[1]), std::min(size[0], size[1])};
        artefact.margin_mm = root.number("margin_mm", 0.03 * artefact.size_mm[1]);
    }
}

void read_limits(TomlTable& root, const std::string& kind, Artefact& artefact) {
    std::optional<TomlTable> mpe = root.find_table("mpe");
    if (!mpe) return;
    if (kind == "plane") {
        artefact.mpe_form_mm = read_optional(*mpe, "flatness_mm");
        return;
    }
    if (kind == "travel") {
        artefact.mpe_linearity_mm = read_optional(*mpe, "linearity_mm");
        artefact.mpe_repeatability_mm = read_optional(*mpe, "repeatability_mm");
        return;
    }
    if (kind == "sphere") {
        artefact.mpe_form_mm = read_optional(*mpe, "form_mm");
        artefact.mpe_size_mm = read_optional(*mpe, "size_mm");
        return;
    }
    artefact.mpe_spacing_mm = read_optional(*mpe, "spacing_mm");
    artefact.mpe_length_mm = read_optional(*mpe, "length_mm");
    if (artefact.mpe_length_mm) artefact.mpe_length_per_mm = mpe->number("length_per_mm", 0.0);
}

}  // namespace

Artefact parse_artefact(const std::string& text, const std::string& name,
                        const std::vector<std::string>& kinds) {
    TomlTable root = parse_toml(text, name);
    const std::string kind = root.text("kind");
    if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) {
        std::string expected;
        for (const std::string& one : kinds)
            expected += (expected.empty() ? "\"" : " or \"") + one + "\"";
        root.refuse("kind", "expected " + expected + ", found \"" + kind + "\"");
    }
    Artefact artefact;
    artefact.name = root.text("name", "");
    read_measures(root, kind, artefact);
    if (kind == "sphere" || kind == "plane") artefact.form_mm = root.number("form_mm", 0.0);
    if (kind == "sphere" || kind == "plane" || kind == "bar")
        artefact.volume_diagonal_mm = read_optional(root, "volume_diagonal_mm");
    if (!artefact.diameters.empty()) artefact.temperature = read_temperature(root);
    read_limits(root, kind, artefact);
    root.finish();
    if (const std::string why = validate(artefact); !why.empty()) root.refuse("kind", why);
    return artefact;
}

Artefact read_artefact(const std::string& path, const std::vector<std::string>& kinds) {
    return parse_artefact(read_whole_file(path, std::size_t{1} << 20), path, kinds);
}

}  // namespace stria
