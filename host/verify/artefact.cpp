#include "host/verify/artefact.h"

#include <cmath>

namespace stria {
namespace {

std::string number(double value) { return std::to_string(value); }

std::string wrong_length(const std::string& field, const CalibratedLength& length) {
    if (!(length.mm > 0 && length.mm <= 20000))
        return field + " " + number(length.mm) + " mm: expected above 0 to 20000";
    if (!(length.expanded_mm >= 0 && length.expanded_mm < 0.01 * length.mm))
        return field + "'s uncertainty " + number(length.expanded_mm) +
               " mm: expected 0 to 1 % of the length";
    return {};
}

std::string wrong_temperature(const Temperature& t) {
    if (!(t.measured_c >= -50 && t.measured_c <= 150))
        return "temperature_c " + number(t.measured_c) + ": expected -50 to 150";
    if (!(t.reference_c >= -50 && t.reference_c <= 150))
        return "reference_c " + number(t.reference_c) + ": expected -50 to 150";
    if (!(std::abs(t.cte_per_k) <= 2e-4))
        return "cte_per_k " + number(t.cte_per_k) +
               ": expected at most 2e-4 (steel has 11.5e-6); is it in 1e-6?";
    if (!(t.measured_expanded_c >= 0 && t.cte_expanded_per_k >= 0))
        return "uncertainty of temperature or expansion: expected 0 or more";
    return {};
}

}  // namespace

double combined(std::initializer_list<double> contributions) {
    double sum = 0;
    for (const double value : contributions) sum += value * value;
    return std::sqrt(sum);
}

CalibratedLength at_temperature(const Artefact& artefact, const CalibratedLength& length) {
    if (!artefact.temperature) return length;
    const Temperature& t = *artefact.temperature;
    const double warmer = t.measured_c - t.reference_c;
    return {length.mm * (1 + t.cte_per_k * warmer),
            combined({length.expanded_mm, length.mm * t.cte_per_k * t.measured_expanded_c,
                      length.mm * warmer * t.cte_expanded_per_k})};
}

std::string validate(const Artefact& artefact) {
    for (const CalibratedLength& diameter : artefact.diameters)
        if (const std::string why = wrong_length("diameter", diameter); !why.empty()) return why;
    if (!(artefact.travelled_expanded_mm >= 0 && artefact.travelled_expanded_mm < 10))
        return "travelled_u_mm " + number(artefact.travelled_expanded_mm) + ": expected 0 to 10";
    for (const CalibratedLength& length : artefact.lengths)
        if (const std::string why = wrong_length("length", length); !why.empty()) return why;
    for (std::size_t i = 1; i < artefact.lengths.size(); ++i)
        if (!(artefact.lengths[i].mm > artefact.lengths[i - 1].mm))
            return "lengths: expected ascending distances from the first sphere";
    if (!(artefact.mpe_length_per_mm >= 0 && artefact.mpe_length_per_mm < 0.1))
        return "length_per_mm " + number(artefact.mpe_length_per_mm) + ": expected 0 to 0.1";
    if (artefact.diameters.empty() && !(artefact.size_mm[1] > 0 && artefact.size_mm[0] <= 20000))
        return "size_mm: expected two sides above 0 to 20000 mm";
    if (!(artefact.margin_mm >= 0 && artefact.margin_mm <= 0.4 * artefact.size_mm[1]))
        return "margin_mm " + number(artefact.margin_mm) +
               ": expected 0 to 0.4 of the shorter side";
    if (!(artefact.form_mm >= 0 && artefact.form_mm < 10))
        return "form_mm " + number(artefact.form_mm) + ": expected 0 to 10";
    if (artefact.volume_diagonal_mm && !(*artefact.volume_diagonal_mm > 0))
        return "volume_diagonal_mm " + number(*artefact.volume_diagonal_mm) + ": expected above 0";
    for (const auto& mpe :
         {artefact.mpe_form_mm, artefact.mpe_size_mm, artefact.mpe_spacing_mm,
          artefact.mpe_length_mm, artefact.mpe_linearity_mm, artefact.mpe_repeatability_mm})
        if (mpe && !(*mpe > 0 && *mpe < 100))
            return "maximum permissible error " + number(*mpe) + " mm: expected above 0 to 100";
    return artefact.temperature ? wrong_temperature(*artefact.temperature) : std::string();
}

Verdict judge(double error_mm, double expanded_mm, const std::optional<double>& mpe_mm) {
    if (!mpe_mm) return Verdict::not_asked;
    if (std::abs(error_mm) + expanded_mm <= *mpe_mm) return Verdict::accepted;
    return std::abs(error_mm) - expanded_mm > *mpe_mm ? Verdict::rejected : Verdict::undecided;
}

const char* name_of(Verdict verdict) {
    switch (verdict) {
        case Verdict::accepted:
            return "accepted";
        case Verdict::undecided:
            return "undecided";
        case Verdict::rejected:
            return "rejected";
        case Verdict::not_asked:
            break;
    }
    return "not asked";
}

}  // namespace stria
