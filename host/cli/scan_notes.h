#pragma once
#include <optional>
#include <string>

#include "host/verify/drift.h"

namespace stria {

/// scan.toml beside a scan's recording and range image: what was known when it was taken. The
/// project's check.toml has the same form: the scan that later checks are compared with.
struct ScanNotes {
    std::string model_hash;  ///< of the calibration that triangulated it; empty: none
    std::optional<double> temperature_c;
    std::string artefact;             ///< name of the check artefact
    std::optional<ShapeCheck> check;  ///< what the scan made of it
};

std::string format_scan_notes(const ScanNotes& notes);
/// Throws FileError with the line.
ScanNotes parse_scan_notes(const std::string& text, const std::string& name);
ScanNotes read_scan_notes(const std::string& path);

}  // namespace stria
