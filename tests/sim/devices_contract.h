#pragma once
#include <functional>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "firmware/devices/devices.h"

namespace stria {

/// A machine under the contract tests: simulated, or real with a dark cover before the camera's
/// view being lit by nothing but its own laser.
class ContractMachine {
  public:
    virtual ~ContractMachine() = default;
    virtual Devices devices() = 0;
};

/// One machine kind; `make` may answer nullptr where there is no hardware, then tests are skipped.
struct ContractCase {
    std::string name;
    std::function<std::unique_ptr<ContractMachine>()> make;
};

inline std::ostream& operator<<(std::ostream& out, const ContractCase& machine) {
    return out << machine.name;
}

}  // namespace stria
