#pragma once
#include <array>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

namespace stria {

/// A length from a calibration certificate. Every uncertainty here is expanded, k = 2.
struct CalibratedLength {
    double mm = 0;
    double expanded_mm = 0;
};

/// Temperature of the artefact while it is measured, and what it does to it.
struct Temperature {
    double reference_c = 20;  ///< that the certificate's lengths hold for (ISO 1)
    double measured_c = 20;   ///< while it is scanned
    double measured_expanded_c = 0;
    double cte_per_k = 0;  ///< linear expansion
    double cte_expanded_per_k = 0;
};

/// What is measured to verify a scanner, as its certificate states it.
struct Artefact {
    std::string name;
    std::vector<CalibratedLength> diameters;  ///< of its spheres, in order along it
    /// Bar or beam of spheres on a line: distance of each further centre from the first, ascending.
    std::vector<CalibratedLength> lengths;
    std::array<double, 2> size_mm{0, 0};  ///< plane: longer and shorter side
    double margin_mm = 0;                 ///< plane: not measured along its border
    std::vector<double> travelled_mm;     ///< flat target on a stage: where it stood, one a scan
    double travelled_expanded_mm = 0;     ///< of the distances between them
    double form_mm = 0;  ///< greatest form error of its surfaces, as certified; 0: not stated
    std::optional<Temperature> temperature;    ///< empty: not stated, lengths are not corrected
    std::optional<double> volume_diagonal_mm;  ///< L0 of the scanner's volume; empty: not stated

    /// Maximum permissible errors, mm, of each characteristic; empty: nothing is asked of it.
    std::optional<double> mpe_form_mm, mpe_size_mm, mpe_spacing_mm, mpe_length_mm;
    std::optional<double> mpe_linearity_mm, mpe_repeatability_mm;
    double mpe_length_per_mm = 0;  ///< added to mpe_length_mm a millimetre of length
};

/// The length at the artefact's measured temperature, with what temperature and expansion add to
/// its uncertainty; unchanged where no temperature is stated.
CalibratedLength at_temperature(const Artefact& artefact, const CalibratedLength& length);

/// Empty, or what makes no sense (field, value, bound).
std::string validate(const Artefact& artefact);

/// Whether an error keeps its limit for certain, by the rule of ISO 14253-1.
enum class Verdict {
    not_asked,  ///< there is no limit
    accepted,   ///< |error| + U <= MPE
    undecided,  ///< within U of the limit
    rejected,   ///< |error| - U > MPE
};
Verdict judge(double error_mm, double expanded_mm, const std::optional<double>& mpe_mm);
/// "not asked", "accepted", "undecided", "rejected".
const char* name_of(Verdict verdict);

/// Root of the sum of squares, for independent contributions to an uncertainty.
double combined(std::initializer_list<double> contributions);

}  // namespace stria
