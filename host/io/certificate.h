#pragma once
#include <optional>
#include <string>
#include <vector>

#include "host/core/scanner_model.h"

namespace stria {

enum class CertificateStatus : std::uint8_t { passed, failed, unchecked };
/// "passed", "failed", "unchecked" (scanner.toml).
const char* name_of(CertificateStatus status);

/// [certificate] of scanner.toml: what an independent check of a calibration found. Lengths in mm.
struct Certificate {
    CertificateStatus status = CertificateStatus::unchecked;
    std::vector<std::string> reasons;  ///< why not passed
    std::string date;     ///< ISO 8601 day; empty when made on a simulated machine: bytes repeat
    std::string expires;  ///< likewise; empty: never
    std::optional<double> temperature_c;
    std::string data_hash;   ///< of the recordings that the model was solved from
    std::string check_hash;  ///< of those that checked it; empty: none
    int views = 0;
    int check_views = 0;
    double precision_mm = 0;          ///< scatter of a point about the board, held-out views
    double trueness_mm = 0;           ///< rms of regions' mean distances from the board
    double expected_trueness_mm = 0;  ///< what the covariance predicts for it
    double check_p_value = 1;         ///< that held-out views and model agree
    double cross_p_value = 1;         ///< that halves agree and residuals are white
    double model_error_px = 0;        ///< part of the corners' residuals that neighbours share
};

/// The [certificate] of a scanner.toml, or none. Throws FileError; `name` stands for the path.
std::optional<Certificate> read_certificate(const std::string& path);
std::optional<Certificate> parse_certificate(const std::string& text, const std::string& name);
std::string format_certificate(const Certificate& certificate);

/// A scanner.toml with its certificate, if there is one.
void write_scanner(const std::string& path, const ScannerModel& model,
                   const std::optional<Certificate>& certificate);

/// What a user of the model should hear: no certificate, a failed or unchecked one (with the first
/// reason), one that expired before `today` (ISO 8601 day), or one made for other data than the
/// model's own hash states. Empty: all is well.
std::string certificate_warning(const std::optional<Certificate>& certificate,
                                const ScannerModel& model, const std::string& today);

/// Day (ISO 8601) that many days after another; throws std::invalid_argument for text that is no
/// day.
std::string days_after(const std::string& day, int days);

}  // namespace stria
