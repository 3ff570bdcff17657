#include "tests/support/synthetic_scanner.h"

#include <Eigen/Geometry>

namespace stria::test_support {
namespace {

using Eigen::Vector3d;

CameraModel camera() {
    CameraModel camera;
    camera.kind = LensKind::brown5;
    camera.width = 640;
    camera.height = 512;
    camera.fx = 1500;
    camera.fy = 1501;
    camera.cx = 321;
    camera.cy = 254;
    camera.distortion = {-0.08, 0.1, 3e-4, -2e-4, 0, 0, 0, 0};
    return camera;
}

/// Flat sheet from `apex` towards `target`, standing upright (containing y).
LaserSheet upright_sheet(const Vector3d& apex, const Vector3d& target) {
    LaserSheet sheet;
    sheet.apex = apex;
    sheet.central_ray = (target - apex).normalized();
    sheet.normal = sheet.central_ray.cross(Vector3d::UnitY()).normalized();
    sheet.offset_mm = sheet.normal.dot(apex);
    sheet.fan_rad = 0.7;
    sheet.waist_sigma_mm = 0.5;
    sheet.waist_at_mm = 460;
    return normalised(sheet);
}

ScannerModel with_channel(const Channel& channel) {
    ScannerModel model;
    model.channels.push_back(channel);
    return model;
}

}  // namespace

ScannerModel swept_scanner() {
    Channel channel;
    channel.camera = camera();
    // The laser stands beside the mirror and shines along -x; the mirror turns it to the object.
    channel.sheet = upright_sheet({260, 0, 20}, {180, 0, 20});
    channel.sheet.waist_at_mm = 540;
    const Vector3d in(-1, 0, 0), out = (Vector3d(0, 0, 450) - Vector3d(180, 0, 20)).normalized();
    channel.axis.kind = MachineKind::swept;
    channel.axis.mirror.direction = Vector3d(0.002, 1, -0.001).normalized();
    channel.axis.mirror.point = {180, 0, 20};
    channel.axis.mirror.normal0 = (out - in).normalized();
    channel.axis.mirror.offset_mm = 0.3;
    return with_channel(channel);
}

ScannerModel rail_scanner() {
    Channel channel;
    channel.camera = camera();
    channel.sheet = upright_sheet({180, 0, 0}, {0, 0, 450});
    channel.axis.kind = MachineKind::rail;
    channel.axis.rail.direction = Vector3d(1, 0.01, -0.02).normalized();
    return with_channel(channel);
}

ScannerModel turntable_scanner() {
    Channel channel;
    channel.camera = camera();
    channel.sheet = upright_sheet({180, 0, 0}, {0, 0, 450});
    channel.axis.kind = MachineKind::turntable;
    // Table axis 450 mm before the camera, pointing up (camera y is down), camera on the table's
    // -y.
    Eigen::Matrix3d turn;
    turn << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    channel.axis.turntable.table_from_camera = {turn, Vector3d(0, -450, 0)};
    return with_channel(channel);
}

}  // namespace stria::test_support
