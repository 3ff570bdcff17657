#pragma once
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "host/cli/command.h"
#include "host/report/report.h"
#include "host/verify/artefact.h"
#include "host/verify/residuals.h"
#include "host/verify/scan_points.h"
#include "host/verify/sphere_region.h"

/// What the verify verbs share: their arguments, their scans, and the way a figure is told to a
/// person, to JSON and to the page.
namespace stria {

/// What a scan states beside its points.
struct ScanStates {
    bool sight = false, noise = false, systematic = false;
};

/// One characteristic, over all positions.
struct VerifyFigure {
    std::string key;   ///< of --json: "form_mm"
    std::string name;  ///< "probing error of form (PF), worst position"
    double value_mm = 0;
    double expanded_mm = 0;  ///< U of the test, k = 2
    std::optional<double> mpe_mm;
};

/// What a run found.
struct VerifyOutcome {
    std::string kind;       ///< "sphere"
    std::string procedure;  ///< "VDI/VDE 2634-2, probing errors of form and size"
    std::string artefact;   ///< its name
    std::vector<VerifyFigure> figures;
    std::size_t points_used = 0, rejected = 0;
    std::vector<std::string> notes;  ///< what is missing or was assumed, a sentence each
    std::vector<JsonResult> positions;
    std::vector<ReportSection> sections;  ///< of the page
};

/// Notes on what scans do not state and on a temperature that is missing.
std::vector<std::string> common_notes(const std::vector<ScanStates>& scans,
                                      const Artefact& artefact);

/// One `stria verify KIND`: reads artefact and scans, has every scan measured, tells the outcome on
/// stdout, as page and as JSON. Exit code 1 where a maximum permissible error is not kept for
/// certain.
class VerifyVerb : public Verb {
  public:
    void declare(Arguments& arguments) override;
    int run(const Context& context) override;

  protected:
    virtual void declare_more(Arguments&) {}
    /// Kinds of artefact that it measures.
    virtual std::vector<std::string> kinds() const = 0;
    /// Refuses options that make no sense (stria::Error), before anything is read.
    virtual void check_options() {}
    /// One position; throws stria::Error without the scan's name.
    virtual void measure(const ScanPoints& scan, std::mt19937& rng) = 0;
    /// All of them; called last.
    virtual VerifyOutcome outcome() const = 0;

    Artefact artefact_;
    std::vector<ScanStates> states_;
    std::vector<std::string> names_;  ///< of the positions measured

  private:
    std::vector<std::string> arguments_;
    std::string artefact_path_, page_;
};

/// --incidence of the verbs that measure spheres.
class IncidenceOption {
  public:
    void declare(Arguments& arguments);
    /// Throws stria::Error.
    SphereRegionOptions region_options() const;

  private:
    std::string text_ = "60";
};

/// The form figures of a position, under the keys that every kind shares.
void set_form(JsonResult& json, const FormFigures& form, const std::string& key = "form_mm");

/// Where the artefact file states no form error of its surface.
inline constexpr const char* kFormNote =
    "The artefact file states no form error of its surface: U of the form error holds nothing.";

/// What every uncertainty of a fit takes for granted.
inline constexpr const char* kIndependentNote =
    "The uncertainty of a fit takes the points' errors as independent. Errors that neighbouring "
    "points share make it larger.";

/// The note where scans or artefact fall short of what the procedure asks for: "The procedure asks
/// for ASKED; FOUND."
std::string falls_short(const std::string& asked, const std::string& found);

/// The note where an artefact's length is not within those shares of the volume's diagonal, or
/// where the artefact file does not state that; empty where all is well.
/// @param most  not finite: none
std::string volume_note(const Artefact& artefact, const std::string& what, double length_mm,
                        double least, double most = std::numeric_limits<double>::infinity());

/// A length in mm to a tenth of a micrometre.
std::string mm_text(double mm);

/// Micrometres: hundredths below 10, three digits above; "-" where not known.
std::string um(double mm);

}  // namespace stria
