// Text that describes a camera, a scanner, its certificate, a plan, poses, an artefact or a scan;
// the first byte says which.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "host/cli/artefact_toml.h"
#include "host/cli/scan_notes.h"
#include "host/core/errors.h"
#include "host/io/certificate.h"
#include "host/io/model_io.h"

namespace {

/// What is written reads back as the same text, bit by bit.
void check_scanner(const stria::ScannerModel& model) {
    const std::string written = stria::format_scanner(model);
    if (stria::format_scanner(stria::parse_scanner(written, "again")) != written) std::abort();
}

void check_notes(const stria::ScanNotes& notes) {
    const std::string written = stria::format_scan_notes(notes);
    if (stria::format_scan_notes(stria::parse_scan_notes(written, "again")) != written)
        std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
    try {
        switch (data[0]) {
            case 'c':
                (void)stria::parse_camera(text, "camera.toml");
                break;
            case 's':
                check_scanner(stria::parse_scanner(text, "scanner.toml"));
                break;
            case 'k':
                (void)stria::parse_certificate(text, "scanner.toml");
                break;
            case 'a':
                (void)stria::parse_artefact(text, "artefact.toml",
                                            {"sphere", "bar", "beam", "plane", "travel"});
                break;
            case 'n':
                check_notes(stria::parse_scan_notes(text, "scan.toml"));
                break;
            case 'l':
                (void)stria::parse_plan(text, "plan.toml");
                break;
            case 'p':
                (void)stria::parse_poses(text, "poses.toml");
                break;
            case 'f':
                (void)stria::parse_poses(text, "bun.conf");
                break;
            case 'm':
                (void)stria::parse_poses(text, "scan.txt");
                break;
            default:
                break;
        }
    } catch (const stria::Error&) {
    }
    return 0;
}
