#pragma once
#include "host/io/certificate.h"
#include "host/io/toml_file.h"

namespace stria {

/// The keys of a [certificate] table; the caller finishes it.
Certificate read_certificate_keys(TomlTable& table);

}  // namespace stria
