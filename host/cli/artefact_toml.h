#pragma once
#include <string>
#include <vector>

#include "host/verify/artefact.h"

namespace stria {

/// Reads artefact.toml: what `stria verify KIND` measures, from its calibration certificate.
/// Lengths in mm, temperatures in degrees Celsius, uncertainties expanded (k = 2). Throws FileError
/// with the line: unknown keys, missing ones, another kind than the verb's, numbers that make no
/// sense. The keys stand in host/verify/README.md.
/// @param kinds  that the verb measures: "sphere", "bar" ...
Artefact read_artefact(const std::string& path, const std::vector<std::string>& kinds);
/// @param name  stands for the path in errors
Artefact parse_artefact(const std::string& text, const std::string& name,
                        const std::vector<std::string>& kinds);

}  // namespace stria
