#include "firmware/session/feature_table.h"

#include <algorithm>
#include <numeric>
#include <sstream>

namespace stria {
namespace {

/// Edits from one name to the other (Levenshtein).
std::size_t distance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0]++;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t change = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, change});
        }
    }
    return row.back();
}

/// `value` in the type of `like`: whole numbers are taken for numbers, numbers without fraction for
/// whole ones, 0 and 1 for booleans.
Result<FeatureValue> converted(const FeatureValue& value, const FeatureValue& like) {
    if (value.index() == like.index()) return value;
    const auto* whole = std::get_if<std::int64_t>(&value);
    const auto* number = std::get_if<double>(&value);
    if (whole != nullptr && std::holds_alternative<double>(like))
        return FeatureValue(static_cast<double>(*whole));
    if (whole != nullptr && std::holds_alternative<bool>(like) && (*whole == 0 || *whole == 1))
        return FeatureValue(*whole == 1);
    if (number != nullptr && std::holds_alternative<std::int64_t>(like) &&
        static_cast<double>(static_cast<std::int64_t>(*number)) == *number)
        return FeatureValue(static_cast<std::int64_t>(*number));
    constexpr const char* kTypes[] = {"a whole number", "a number", "a text", "true or false"};
    return Failure{std::string("expected ") + kTypes[like.index()] + ", found " +
                   kTypes[value.index()]};
}

std::optional<double> number_of(const FeatureValue& value) {
    if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
    if (const auto* flag = std::get_if<bool>(&value)) return *flag ? 1.0 : 0.0;
    if (const auto* number = std::get_if<double>(&value)) return *number;
    return std::nullopt;
}

Status check_range(const Feature& feature, const FeatureValue& value) {
    const auto number = number_of(value);
    if (!feature.range || !number) return {};
    if (*number >= feature.range->min && *number <= feature.range->max) return {};
    std::ostringstream text;
    text << feature.name << " = " << *number << ": expected " << feature.range->min << " to "
         << feature.range->max << (feature.unit.empty() ? "" : " ") << feature.unit << " ("
         << feature.range->reason << ")";
    return Failure{text.str()};
}

}  // namespace

FeatureTable::FeatureTable(std::vector<DeviceFeature> features) : features_(std::move(features)) {}

std::vector<Feature> FeatureTable::all() const {
    std::vector<Feature> list;
    for (const DeviceFeature& feature : features_) list.push_back(feature.read());
    return list;
}

Result<const DeviceFeature*> FeatureTable::find(const std::string& name) const {
    std::string nearest;
    std::size_t least = 0;
    for (const DeviceFeature& feature : features_) {
        const std::string known = feature.read().name;
        if (known == name) return &feature;
        const std::size_t edits = distance(name, known);
        if (!nearest.empty() && edits >= least) continue;
        least = edits;
        nearest = known;
    }
    return Failure{"there is no feature \"" + name + "\"; the nearest is \"" + nearest + "\""};
}

Result<Feature> FeatureTable::get(const std::string& name) const {
    const auto found = find(name);
    if (!found) return found.failure();
    return (*found)->read();
}

Result<Feature> FeatureTable::set(const std::string& name, const FeatureValue& value) {
    const auto found = find(name);
    if (!found) return found.failure();
    const Feature feature = (*found)->read();
    if (feature.access == Access::read || !(*found)->write)
        return Failure{name + " can only be read"};
    const auto typed = converted(value, feature.value);
    if (!typed) return Failure{name + ": " + typed.failure().message};
    if (Status inside = check_range(feature, *typed); !inside) return inside.failure();
    if (Status done = (*found)->write(*typed); !done) return done.failure();
    return (*found)->read();
}

}  // namespace stria
