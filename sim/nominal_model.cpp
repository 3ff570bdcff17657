#include "sim/nominal_model.h"

#include "sim/random.h"

namespace stria {
namespace {

/// Seeded disturbances, one after the other.
class Errors {
  public:
    explicit Errors(std::uint64_t seed) : seed_(seed) {}
    double normal(double sigma) {
        return sigma * counter_random::normal(seed_, counter_random::kNominal, next_++);
    }
    Eigen::Vector3d vector(double sigma) {
        const double x = normal(sigma), y = normal(sigma), z = normal(sigma);
        return {x, y, z};
    }
    Eigen::Vector3d turned(const Eigen::Vector3d& direction, double sigma_rad) {
        return rotation_from_vector(vector(sigma_rad)) * direction;
    }

  private:
    std::uint64_t seed_;
    std::uint64_t next_ = 0;
};

void disturb_axis(AxisModel& axis, const SceneNominal& nominal, Errors& errors) {
    axis.delay_ns = 0;
    switch (axis.kind) {
        case MachineKind::swept: {
            MirrorAxis& mirror = axis.mirror;
            mirror.direction = errors.turned(mirror.direction, nominal.rotation_sigma_rad);
            mirror.normal0 = errors.turned(mirror.normal0, nominal.rotation_sigma_rad);
            mirror.point += errors.vector(nominal.position_sigma_mm);
            const Eigen::Vector3d along = mirror.direction.dot(mirror.point) * mirror.direction;
            mirror.offset_mm += mirror.normal0.dot(along);  // the plane stays
            mirror.point -= along;
            mirror.offset_mm += errors.normal(nominal.position_sigma_mm);
            mirror.g2 = mirror.g3 = 0;
            break;
        }
        case MachineKind::rail:
            axis.rail.direction = errors.turned(axis.rail.direction, nominal.rotation_sigma_rad);
            break;
        case MachineKind::turntable: {
            Rigid3& table = axis.turntable.table_from_camera;
            const Eigen::Matrix3d turn =
                rotation_from_vector(errors.vector(nominal.rotation_sigma_rad));
            // Turned about the camera, so that the part stays in view.
            table.rotation = table.rotation * turn;
            table.translation += errors.vector(nominal.position_sigma_mm);
            break;
        }
    }
}

}  // namespace

ScannerModel truth_model(const Scene& scene) {
    ScannerModel model;
    model.channels.push_back(scene.channel);
    model.provenance.made_by = "stria simulator, truth";
    return model;
}

ScannerModel nominal_model(const Scene& scene, std::uint64_t seed) {
    Errors errors(seed);
    const SceneNominal& nominal = scene.nominal;
    ScannerModel model = truth_model(scene);
    model.provenance.made_by = "stria simulator, design";
    Channel& channel = model.channels.front();

    CameraModel& camera = channel.camera;
    const double focal = 1 + errors.normal(nominal.focal_relative_sigma);
    camera.fx *= focal;
    camera.fy *= focal;
    camera.cx = (camera.width - 1) / 2.0;
    camera.cy = (camera.height - 1) / 2.0;
    camera.distortion = {};

    LaserSheet& sheet = channel.sheet;
    const Eigen::Matrix3d turn = rotation_from_vector(errors.vector(nominal.rotation_sigma_rad));
    sheet.normal = turn * sheet.normal;
    sheet.central_ray = turn * sheet.central_ray;
    sheet.apex += errors.vector(nominal.position_sigma_mm);
    sheet.offset_mm = sheet.normal.dot(sheet.apex);
    sheet.bow2 = sheet.bow3 = 0;
    sheet = normalised(sheet);

    disturb_axis(channel.axis, nominal, errors);
    return model;
}

}  // namespace stria
