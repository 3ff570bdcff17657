#pragma once
#include <string>
#include <vector>

namespace stria {

/// Folders where scanners on this computer put their sockets: /run/stria and, for servers that a
/// user starts, $XDG_RUNTIME_DIR/stria.
std::vector<std::string> socket_folders();

/// "unix:PATH" of every socket in those folders, sorted; whether something listens there is not
/// tried. Folders that are missing or cannot be read hold none.
std::vector<std::string> find_sockets(const std::vector<std::string>& folders);

}  // namespace stria
