#pragma once
#include <Eigen/Geometry>
#include <random>

#include "host/core/scanner_model.h"

/// Models with every parameter in play, for properties that must hold for all of them.
namespace stria {

struct RandomModels {
    std::mt19937 rng;
    explicit RandomModels(unsigned seed) : rng(seed) {}

    double uniform(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(rng);
    }
    Eigen::Vector3d vector(double size) {
        return {uniform(-size, size), uniform(-size, size), uniform(-size, size)};
    }
    Eigen::Vector3d unit() {
        std::normal_distribution<double> normal;
        return Eigen::Vector3d(normal(rng), normal(rng), normal(rng)).normalized();
    }
    Rigid3 motion(double mm) {
        return {rotation_from_vector(uniform(0.1, 3.0) * unit()), vector(mm)};
    }
    CameraModel camera() {
        CameraModel camera{LensKind::brown5, 1280, 1024, 1500, 1510, 640, 510, {}};
        camera.distortion = {uniform(-0.2, 0.2), uniform(-0.1, 0.1), uniform(-0.002, 0.002),
                             uniform(-0.002, 0.002), uniform(-0.02, 0.02)};
        return camera;
    }
    /// A sheet that crosses the camera's view about 300 mm before it, its apex 100 mm to the side.
    LaserSheet sheet(double bow) {
        LaserSheet sheet;
        sheet.apex = Eigen::Vector3d(100, 0, 0) + vector(5);
        const Eigen::Vector3d target = Eigen::Vector3d(0, 0, 300) + vector(10);
        sheet.central_ray = (target - sheet.apex).normalized();
        const Eigen::Vector3d along = Eigen::Vector3d(uniform(-0.1, 0.1), 1, uniform(-0.1, 0.1));
        sheet.normal = along.cross(sheet.central_ray).normalized();
        sheet.offset_mm = sheet.normal.dot(sheet.apex);
        if (sheet.offset_mm < 0) {
            sheet.normal = -sheet.normal;
            sheet.offset_mm = -sheet.offset_mm;
        }
        sheet.bow2 = uniform(-bow, bow);
        sheet.bow3 = uniform(-bow, bow);
        return sheet;
    }
    Channel channel(MachineKind kind, double bow) {
        Channel channel;
        channel.camera = camera();
        channel.sheet = sheet(bow);
        channel.axis.kind = kind;
        if (kind == MachineKind::swept) make_swept(channel);
        if (kind == MachineKind::rail)
            channel.axis.rail.direction = (Eigen::Vector3d(1, 0, 0) + vector(0.1)).normalized();
        if (kind == MachineKind::turntable) channel.axis.turntable.table_from_camera = motion(200);
        return channel;
    }

  private:
    /// Puts the incoming sheet where the mirror at s = 0 shows the sheet made above.
    void make_swept(Channel& channel) {
        MirrorAxis& mirror = channel.axis.mirror;
        mirror.direction = (Eigen::Vector3d(0, 1, 0) + vector(0.05)).normalized();
        mirror.normal0 = (Eigen::Vector3d(-1, 0, 1) + vector(0.1)).normalized();
        mirror.point = Eigen::Vector3d(95, 0, 20) + vector(3);
        mirror.point -= mirror.point.dot(mirror.direction) * mirror.direction;
        mirror.offset_mm = uniform(-2, 2);
        mirror.g2 = uniform(-0.01, 0.01);
        mirror.g3 = uniform(-0.01, 0.01);
        channel.sheet = reflected(channel.sheet, mirror.normal0, mirror.point, mirror.offset_mm);
    }
};

}  // namespace stria
