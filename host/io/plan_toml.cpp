#include <algorithm>

#include "host/core/errors.h"
#include "host/io/model_io.h"
#include "host/io/number_text.h"
#include "host/io/toml_text.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

/// The index of the key's text among the choices.
std::size_t read_choice(TomlTable& table, const std::string& key,
                        const std::vector<std::string>& choices, std::size_t otherwise) {
    const std::string value = table.text(key, choices[otherwise]);
    for (std::size_t i = 0; i < choices.size(); ++i)
        if (choices[i] == value) return i;
    std::string expected = choices[0];
    for (std::size_t i = 1; i < choices.size(); ++i)
        expected += (i + 1 == choices.size() ? " or " : ", ") + choices[i];
    table.refuse(key, "expected " + expected + ", found '" + value + "'");
}

const std::vector<std::string> kModes = {"spatial", "spacetime"};        // as StripeMode
const std::vector<std::string> kRecords = {"pulses", "frames", "both"};  // as RecordWhat

}  // namespace

ScanPlan parse_plan(const std::string& text, const std::string& name) {
    TomlTable table = parse_toml(text, name);
    ScanPlan plan;
    plan.mode = static_cast<StripeMode>(
        read_choice(table, "mode", kModes, static_cast<std::size_t>(plan.mode)));
    plan.from = table.number("from");
    plan.to = table.number("to");
    plan.step = table.number("step");
    if (table.has("exposures_us")) plan.exposures_us = table.numbers("exposures_us");
    plan.laser_power = table.number("laser_power", plan.laser_power);
    if (table.has("lasers")) {
        plan.lasers.clear();
        for (const double id : table.numbers("lasers")) {
            if (!(id >= 0 && id <= 255 && id == static_cast<double>(static_cast<int>(id))))
                table.refuse("lasers", "expected numbers of lasers, 0 to 255");
            plan.lasers.push_back(static_cast<std::uint8_t>(id));
        }
    }
    plan.off_frames =
        static_cast<int>(std::clamp<std::int64_t>(table.integer("off_frames", 0), -1, 1 << 20));
    plan.off_exposure_us = table.number("off_exposure_us", 0.0);
    plan.both_directions = table.boolean("both_directions", false);
    plan.record = static_cast<RecordWhat>(
        read_choice(table, "record", kRecords, static_cast<std::size_t>(plan.record)));
    plan.max_emission_s = table.number("max_emission_s", plan.max_emission_s);
    table.finish();
    if (const std::string why = validate(plan); !why.empty())
        table.refuse(why.substr(0, why.find(' ')), why);
    return plan;
}

ScanPlan read_plan(const std::string& path) {
    return parse_plan(read_whole_file(path, std::size_t{1} << 20), path);
}

std::string format_plan(const ScanPlan& plan) {
    std::string text = "mode = " + toml_text(kModes[static_cast<std::size_t>(plan.mode)]) + "\n";
    text += "from = " + toml_number(plan.from) + "\nto = " + toml_number(plan.to) +
            "\nstep = " + toml_number(plan.step) + "\n";
    text += toml_line("exposures_us", plan.exposures_us);
    text += "laser_power = " + toml_number(plan.laser_power) + "\nlasers = [";
    for (std::size_t i = 0; i < plan.lasers.size(); ++i)
        text += (i ? ", " : "") + std::to_string(plan.lasers[i]);
    text += "]\noff_frames = " + std::to_string(plan.off_frames) + "\n";
    text += "off_exposure_us = " + toml_number(plan.off_exposure_us) + "\n";
    text += std::string("both_directions = ") + (plan.both_directions ? "true" : "false") + "\n";
    text += "record = " + toml_text(kRecords[static_cast<std::size_t>(plan.record)]) + "\n";
    return text + "max_emission_s = " + toml_number(plan.max_emission_s) + "\n";
}

}  // namespace stria
