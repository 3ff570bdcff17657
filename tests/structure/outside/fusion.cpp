#include <stdexcept>

#include "host/fusion/fuse.h"

int main() {
    // Without scans there is no surface.
    try {
        return stria::fuse({}).mesh.triangles.empty() ? 0 : 1;
    } catch (const std::exception&) {
        return 0;
    }
}
