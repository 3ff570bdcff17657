#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "host/cli/demo/sculpture.h"
#include "host/core/rigid3.h"

namespace stria {

/// From where the object was really seen in one placement, object frame. The field is that of the
/// true camera; only the comparison with the truth uses it.
struct TrueView {
    Eigen::Vector3d camera;  ///< mm
    Eigen::Vector3d laser;   ///< mm
    Rigid3 camera_from_object;
    double half_field_x = 0;  ///< tan of the half opening
    double half_field_y = 0;
};

/// The sculpture as an oracle: nearest true surface, creases, and what could be seen of it.
class SculptureTruth {
  public:
    explicit SculptureTruth(const std::vector<SculpturePart>& parts);
    ~SculptureTruth();

    const TriMesh& mesh() const { return mesh_; }

    struct Nearest {
        Eigen::Vector3d point;
        Eigen::Vector3d normal;  ///< unit, outwards
        double distance_mm;
        bool relief;
    };
    Nearest nearest(const Eigen::Vector3d& point) const;
    /// Signed distance (mm) from the true surface to `point` along unit `direction`; empty if there
    /// is no surface within reach_mm.
    std::optional<double> error_along(const Eigen::Vector3d& point,
                                      const Eigen::Vector3d& direction, double reach_mm) const;
    /// True within that distance of a sharp edge or of a line where two parts meet.
    bool is_near_crease(const Eigen::Vector3d& point, double distance_mm) const;
    /// True if some view sees the point, by camera and laser, flatter than 70 deg by neither.
    bool is_seen(const Eigen::Vector3d& point, const Eigen::Vector3d& normal,
                 const std::vector<TrueView>& views) const;

    struct Sample {
        Eigen::Vector3d point, normal;
        bool relief;
    };
    /// Points spread evenly over the area, seeded; those inside another part included.
    std::vector<Sample> samples(std::size_t count, unsigned seed) const;

  private:
    struct Trees;
    TriMesh mesh_;
    std::vector<std::size_t> first_triangle_;  ///< of each part, and the end
    std::unique_ptr<Trees> trees_;
};

/// Rigid motion that best lays points on the true surface, from a start that is off by at most some
/// mm: point-to-plane Gauss-Newton, distances above `gate_mm` left out (it narrows by halves).
Rigid3 fit_to_truth(const SculptureTruth& truth, const std::vector<Eigen::Vector3d>& points,
                    const Rigid3& start, double gate_mm = 2.0);

}  // namespace stria
