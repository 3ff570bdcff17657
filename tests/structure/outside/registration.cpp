#include <stdexcept>
#include <vector>

#include "host/registration/joint.h"

int main() {
    // Two empty scans: refused or not converged, but never a pose out of nothing.
    const std::vector<stria::ScanSurface> scans(2);
    try {
        const stria::JointResult result =
            stria::register_jointly(scans, std::vector<stria::ScanPose>(2), {});
        return result.converged ? 1 : 0;
    } catch (const std::exception&) {
        return 0;
    }
}
