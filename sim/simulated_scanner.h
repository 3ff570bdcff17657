#pragma once
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/devices/devices.h"
#include "host/core/range_image.h"
#include "host/core/scanner_model.h"
#include "sim/scene.h"

namespace stria {

/// A scanner made of a scene: devices on a virtual clock that moves only when something waits on
/// it. What it shows depends on scene, seed, view and the calls made, never on threads or on real
/// time: every random number is a function of (seed, view, frame, pixel).
///
/// Time: a frame is delivered at the end of its exposure; frames not fetched for 16 frame periods
/// are lost. The axis moves at constant speed, first at max_speed to a run-up of 20 ms before
/// `from`, then through `to` to as far beyond. Laser changes take effect at once.
/// Device calls may come from several threads; the others belong to one owner.
class SimulatedScanner {
  public:
    /// Throws std::invalid_argument where validate(scene) complains.
    /// @param seed  mixed with the scene's own
    SimulatedScanner(const Scene& scene, unsigned seed);
    ~SimulatedScanner();
    SimulatedScanner(const SimulatedScanner&) = delete;
    SimulatedScanner& operator=(const SimulatedScanner&) = delete;

    /// Valid as long as the scanner.
    Devices devices();

    const Scene& scene() const;
    int view_count() const;
    int view() const;
    /// Puts the objects where that view has them; takes effect for later frames. The camera must be
    /// stopped. Costs the primary hits of every pixel again at the next frame (swept).
    void set_view(int view);

    /// The geometry that frames are rendered with. For tests and comparison only: what calibrates
    /// or measures starts from nominal_model().
    ScannerModel truth_model() const;
    /// The design, seeded errors included: what the device may state about itself.
    ScannerModel nominal_model() const;
    /// The same as scanner.toml.
    std::string nominal_model_text() const;

    /// Where the axis really was at a frame's time stamp (delay included), for comparison only.
    double true_axis_position(TimeNs stamp_ns) const;

    /// What a perfect scan of the present view would hold, scan frame. Swept: the first surface
    /// point of each pixel centre that the laser reaches as well, s the position where the sheet
    /// passes it; `frame_s` is not used. Rail, turntable: column k, row v the point where the
    /// sheet's centre at s = frame_s[k] meets the surface in image row v, seen by camera and laser;
    /// further ones as further returns.
    RangeImage true_range(std::span<const double> frame_s = {}) const;

    /// Signed error (mm) of a point of this view's scan along a unit direction, see
    /// SceneGeometry::error_along.
    std::optional<double> error_along(const Eigen::Vector3d& point_in_scan,
                                      const Eigen::Vector3d& direction,
                                      double reach_mm = 2.0) const;

  private:
    struct Content;
    std::unique_ptr<Content> content_;
};

}  // namespace stria
