#include "sim/simulated_scanner.h"

#include <cmath>
#include <stdexcept>

#include "host/io/model_io.h"
#include "sim/machine.h"
#include "sim/nominal_model.h"
#include "sim/random.h"
#include "sim/simulated_devices.h"
#include "sim/true_range.h"

namespace stria {

struct SimulatedScanner::Content {
    Content(const Scene& scene, std::uint64_t seed) : machine(scene, seed), devices(machine) {}
    Machine machine;
    SimulatedDevices devices;
};

namespace {

const Scene& checked(const Scene& scene) {
    if (const std::string why = validate(scene); !why.empty())
        throw std::invalid_argument("scene: " + why);
    return scene;
}

}  // namespace

SimulatedScanner::SimulatedScanner(const Scene& scene, unsigned seed)
    : content_(
          std::make_unique<Content>(checked(scene), counter_random::mix64(scene.seed) ^ seed)) {}

SimulatedScanner::~SimulatedScanner() = default;

Devices SimulatedScanner::devices() { return content_->devices.devices(); }
const Scene& SimulatedScanner::scene() const { return content_->machine.scene; }
int SimulatedScanner::view_count() const { return stria::view_count(scene()); }
int SimulatedScanner::view() const { return content_->machine.view; }

void SimulatedScanner::set_view(int view) {
    const std::lock_guard lock(content_->machine.mutex);
    if (content_->machine.running)
        throw std::invalid_argument("set_view: the camera runs: expected it stopped");
    content_->machine.geometry.set_view(view);
    content_->machine.view = view;
}

ScannerModel SimulatedScanner::truth_model() const { return stria::truth_model(scene()); }

ScannerModel SimulatedScanner::nominal_model() const {
    return stria::nominal_model(scene(), content_->machine.seed);
}

std::string SimulatedScanner::nominal_model_text() const { return format_scanner(nominal_model()); }

double SimulatedScanner::true_axis_position(TimeNs stamp_ns) const {
    const std::lock_guard lock(content_->machine.mutex);
    const double delay = content_->machine.scene.channel.axis.delay_ns;
    return content_->machine.true_position(stamp_ns + static_cast<TimeNs>(std::llround(delay)));
}

RangeImage SimulatedScanner::true_range(std::span<const double> frame_s) const {
    const Machine& machine = content_->machine;
    return machine.scene.channel.axis.kind == MachineKind::swept
               ? true_range_swept(machine.scene, machine.geometry)
               : true_range_of_frames(machine.scene, machine.geometry, frame_s);
}

std::optional<double> SimulatedScanner::error_along(const Eigen::Vector3d& point_in_scan,
                                                    const Eigen::Vector3d& direction,
                                                    double reach_mm) const {
    return content_->machine.geometry.error_along(point_in_scan, direction, reach_mm);
}

}  // namespace stria
