#include "host/link/discover.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

namespace stria {

std::vector<std::string> socket_folders() {
    std::vector<std::string> folders = {"/run/stria"};
    const char* runtime = std::getenv("XDG_RUNTIME_DIR");
    if (runtime != nullptr && *runtime != '\0') folders.push_back(std::string(runtime) + "/stria");
    return folders;
}

std::vector<std::string> find_sockets(const std::vector<std::string>& folders) {
    std::vector<std::string> found;
    for (const std::string& folder : folders) {
        std::error_code none;
        for (std::filesystem::directory_iterator it(folder, none), end; !none && it != end;
             it.increment(none))
            if (it->is_socket(none)) found.push_back("unix:" + it->path().string());
    }
    std::sort(found.begin(), found.end());
    return found;
}

}  // namespace stria
