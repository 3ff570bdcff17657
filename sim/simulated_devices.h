#pragma once
#include <memory>

#include "firmware/devices/devices.h"
#include "sim/machine.h"

namespace stria {

/// Clock, camera, laser, axis and interlock of one simulated machine, which must outlive them.
class SimulatedDevices {
  public:
    explicit SimulatedDevices(Machine& machine);
    Devices devices() { return {*clock_, *camera_, *laser_, *axis_, *interlock_}; }

  private:
    std::unique_ptr<Clock> clock_;
    std::unique_ptr<Camera> camera_;
    std::unique_ptr<Laser> laser_;
    std::unique_ptr<Axis> axis_;
    std::unique_ptr<Interlock> interlock_;
};

}  // namespace stria
