#pragma once
#include <optional>
#include <string>

#include "host/cli/command.h"
#include "host/cli/scan_notes.h"
#include "host/core/range_image.h"

namespace stria {

/// --check of `scan`: a sphere or plane in view, whose shape tells drift since the calibration.
class DriftCheck {
  public:
    void declare(Arguments& arguments);
    bool is_asked() const { return !path_.empty(); }
    bool becomes_reference() const { return becomes_reference_; }
    /// Reads the artefact; before the scan, so that nothing is scanned for a wrong file. Throws
    /// stria::Error and FileError.
    void read();
    /// Measures the artefact (its surface's edges left out), says what came of it, and adds `check`
    /// to the result. Drift is judged by the reference, if it is of this artefact and calibration;
    /// else how far the artefact is off its certificate is said, and no more. With
    /// --check-as-reference the scan becomes the reference.
    /// @param notes           model_hash filled in; receives the check
    /// @param reference_path  check.toml
    void run(const Context& context, const RangeImage& image, const std::string& reference_path,
             ScanNotes& notes, JsonResult& result) const;

  private:
    std::optional<ScanNotes> reference(const Context& context, const std::string& path,
                                       const ScanNotes& notes) const;

    std::string path_;
    bool becomes_reference_ = false;
    Artefact artefact_;
};

}  // namespace stria
