#include "sim/scene.h"

#include <algorithm>

namespace stria {
const char* name_of(SpeckleModel model) {
    switch (model) {
        case SpeckleModel::surface:
            return "surface";
        case SpeckleModel::screen:
            return "screen";
        case SpeckleModel::none:
            break;
    }
    return "none";
}

bool is_blurred(const SceneLens& lens) { return lens.psf_sigma_px > 0 || lens.focus_mm > 0; }

int view_count(const Scene& scene) { return std::max(1, static_cast<int>(scene.views.size())); }

double full_scale_e(const SceneSensor& sensor) {
    const double top_dn = static_cast<double>((1 << sensor.bits) - 1) - sensor.black_dn;
    return std::min(sensor.full_well_e, top_dn * sensor.gain_e_per_dn);
}

Scene built_in_scene() {
    Scene scene;
    CameraModel& camera = scene.channel.camera;
    camera = {.kind = LensKind::brown5,
              .width = 800,
              .height = 640,
              .fx = 1150,
              .fy = 1150,
              .cx = 401.2,
              .cy = 317.8,
              .distortion = {-0.08, 0.05, 2e-4, -1e-4, 0, 0, 0, 0}};

    // The laser sits above the mirror and shines down on it; the mirror sends the sheet forward.
    LaserSheet& sheet = scene.channel.sheet;
    const Eigen::Vector3d mirror_centre(170, 0, -20);
    sheet.apex = mirror_centre + Eigen::Vector3d(60, 0, 0);
    sheet.central_ray = -Eigen::Vector3d::UnitX();
    sheet.normal = Eigen::Vector3d::UnitZ();
    sheet.offset_mm = sheet.normal.dot(sheet.apex);
    sheet.fan_rad = 0.9;
    sheet.waist_sigma_mm = 0.22;
    sheet.waist_at_mm = 480;
    sheet.bow2 = 2e-4;
    sheet = normalised(sheet);

    // Turning the beam from -x to the direction of the object's middle, 400 mm ahead.
    MirrorAxis& mirror = scene.channel.axis.mirror;
    const Eigen::Vector3d forward = (Eigen::Vector3d(0, 0, 400) - mirror_centre).normalized();
    mirror.direction = Eigen::Vector3d::UnitY();
    mirror.point = mirror_centre;
    mirror.normal0 = (forward - sheet.central_ray).normalized();
    mirror.offset_mm = 0.8;
    mirror.g2 = 0.01;
    scene.channel.axis.kind = MachineKind::swept;
    scene.channel.axis.delay_ns = 20000;
    scene.axis = {.min = -0.16, .max = 0.16, .max_speed = 4, .sigma = 2e-6, .log_period_us = 500};

    SceneObject sphere;
    sphere.name = "sphere";
    sphere.shape = SceneShape::sphere;
    sphere.radius_mm = 40;
    sphere.world_from_object.translation = {-20, 5, -400};
    SceneObject plate;
    plate.name = "plate";
    plate.shape = SceneShape::plane;
    plate.size_mm = {260, 200};
    plate.corner_mm = -plate.size_mm / 2;
    plate.world_from_object = {rotation_from_vector({0.1, 0.15, 0}), {0, 0, -450}};
    plate.albedo = 0.6;
    plate.roughness_rad = 0.3;
    SceneObject step = plate;
    step.name = "step";
    step.size_mm = {50, 80};
    step.corner_mm = -step.size_mm / 2;
    step.world_from_object.translation = {65, -10, -420};
    step.albedo = 0.85;
    scene.objects = {sphere, plate, step};
    scene.ambient_level = 0.05;
    scene.sensor.black_dn = 4;
    return scene;
}

}  // namespace stria
