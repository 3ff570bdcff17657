#include "firmware/acquire/safe_state.h"

#include <string>

namespace stria {
namespace {

template <typename Call>
void insist(Call call, const char* part, std::string& refused) {
    if (call()) return;
    const Status again = call();
    if (again) return;
    refused += std::string(refused.empty() ? "" : "; ") + part + ": " + again.failure().message;
}

}  // namespace

Status make_safe(const Devices& devices) {
    std::string refused;
    insist([&] { return devices.laser.off(); }, "laser does not turn off", refused);
    for (Laser* laser : devices.further_lasers)
        insist([&] { return laser->off(); }, "laser does not turn off", refused);
    insist([&] { return devices.axis.stop(); }, "axis does not stop", refused);
    insist([&] { return devices.camera.stop(); }, "camera does not stop", refused);
    if (refused.empty()) return {};
    return Failure{refused};
}

}  // namespace stria
