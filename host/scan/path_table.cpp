#include "host/scan/path_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/core/errors.h"

namespace stria {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kLongestTurn = 0.05;  // rad: nearer the axis the parabola is of the start alone
constexpr double kTrustedPx = 0.015;   // at the middle and corners of a cell; 0.02 anywhere

/// Where the point, in the camera frame when the axis is at 0, is seen when it is at s.
std::optional<Vector2d> image_of(const Channel& channel, const Vector3d& point_at_zero, double s) {
    const Rigid3 camera_from_scan = scan_from_camera(channel, s).inverse();
    return project(channel.camera,
                   camera_from_scan * (scan_from_camera(channel, 0) * point_at_zero));
}

/// Axis travel in which the sheet crosses one standard deviation of the beam.
double width_in_s(const Channel& channel, const Vector3d& point) {
    const double h = channel.axis.kind == MachineKind::turntable ? 1e-5 : 1e-3;  // rad, mm
    const auto distance = [&](double s) {
        const Rigid3 camera_from_scan = scan_from_camera(channel, s).inverse();
        return signed_distance(channel.sheet,
                               camera_from_scan * (scan_from_camera(channel, 0) * point));
    };
    const double speed = std::abs(distance(h) - distance(-h)) / (2 * h);
    return sigma_at(channel.sheet, point) / speed;
}

std::optional<ImagePath> path_through(const Channel& channel, const Vector2d& pixel) {
    const auto hit = triangulate(channel, pixel, 0);
    if (!hit) return std::nullopt;
    const Vector3d point = scan_from_camera(channel, 0).inverse() * hit->point_in_scan;
    ImagePath path;
    path.width_s = width_in_s(channel, point);
    const double most = channel.axis.kind == MachineKind::turntable
                            ? kLongestTurn
                            : std::numeric_limits<double>::infinity();
    const double h = std::min(1.5 * path.width_s, most);
    if (!std::isfinite(h) || !(h > 0)) return std::nullopt;
    const auto before = image_of(channel, point, -h), after = image_of(channel, point, h);
    if (!before || !after) return std::nullopt;
    const Vector2d slope = (*after - *before) / (2 * h);
    const Vector2d bend = (*after + *before - 2 * pixel) / (h * h);
    path.du = slope.x();
    path.dv = slope.y();
    path.ddu = bend.x();
    path.ddv = bend.y();
    return path;
}

/// Greatest distance (px) of the table's path through a pixel from the exact one.
double path_error(const Channel& channel, const PathTable& table, const Vector2d& pixel) {
    const auto path = path_at(table, pixel.x(), pixel.y());
    const auto hit = triangulate(channel, pixel, 0);
    if (!path || !hit) return 0;
    const Vector3d point = scan_from_camera(channel, 0).inverse() * hit->point_in_scan;
    double worst = 0;
    for (const double widths : {-3.0, -2.0, -0.7, 0.7, 2.0, 3.0}) {
        const double ds = widths * path->width_s;
        const auto exact = image_of(channel, point, ds);
        if (!exact) return std::numeric_limits<double>::infinity();
        const Vector2d told(pixel.x() + ds * (path->du + 0.5 * ds * path->ddu),
                            pixel.y() + ds * (path->dv + 0.5 * ds * path->ddv));
        worst = std::max(worst, (told - *exact).norm());
    }
    return worst;
}

/// Where the table is wrong, which near a turntable's axis it is, for points there hardly move and
/// turn back: nodes that are wrong themselves are not valid, nor is the node of the widest pulse in
/// cells that are wrong between their nodes.
void keep_true_nodes(const Channel& channel, PathTable& table) {
    const double across = (table.image_width - 1.0) / (table.nodes_x - 1);
    const double down = (table.image_height - 1.0) / (table.nodes_y - 1);
    const auto error_at = [&](double column, double row) {
        return path_error(channel, table, {column * across, row * down});
    };
    const auto node = [&](int column, int row) {
        return static_cast<std::size_t>(row * table.nodes_x + column);
    };
    std::vector<std::uint8_t> valid = table.valid;
    for (int row = 0; row < table.nodes_y; ++row)
        for (int column = 0; column < table.nodes_x; ++column)
            if (error_at(column, row) > kTrustedPx) valid[node(column, row)] = 0;
    table.valid = valid;
    for (int row = 0; row + 1 < table.nodes_y; ++row)
        for (int column = 0; column + 1 < table.nodes_x; ++column) {
            const double worst =
                std::max({error_at(column + 0.5, row + 0.5), error_at(column + 0.5, row),
                          error_at(column, row + 0.5), error_at(column + 0.5, row + 1),
                          error_at(column + 1, row + 0.5)});
            if (worst < kTrustedPx) continue;
            std::size_t widest = node(column, row);
            for (const std::size_t k :
                 {node(column + 1, row), node(column, row + 1), node(column + 1, row + 1)})
                if (table.width_s[k] > table.width_s[widest]) widest = k;
            valid[widest] = 0;
        }
    table.valid = valid;
}

}  // namespace

PathTable make_path_table(const Channel& channel, const std::string& model_hash, int nodes) {
    if (channel.axis.kind == MachineKind::swept)
        throw Error("image paths: a swept machine has none, its pixels are surface points");
    PathTable table;
    table.camera_id = channel.camera_id;
    table.laser_id = channel.laser_id;
    table.image_width = channel.camera.width;
    table.image_height = channel.camera.height;
    table.nodes_x = table.nodes_y = nodes;
    table.model_hash = model_hash;
    for (int row = 0; row < nodes; ++row)
        for (int column = 0; column < nodes; ++column) {
            const Vector2d pixel(column * (table.image_width - 1.0) / (nodes - 1),
                                 row * (table.image_height - 1.0) / (nodes - 1));
            const auto found = path_through(channel, pixel);
            const ImagePath path = found.value_or(ImagePath{});
            table.du_ds.push_back(static_cast<float>(path.du));
            table.dv_ds.push_back(static_cast<float>(path.dv));
            table.d2u_ds2.push_back(static_cast<float>(path.ddu));
            table.d2v_ds2.push_back(static_cast<float>(path.ddv));
            table.width_s.push_back(static_cast<float>(path.width_s));
            table.valid.push_back(found ? 1 : 0);
        }
    keep_true_nodes(channel, table);
    if (const std::string wrong = validate(table); !wrong.empty()) throw Error(wrong);
    return table;
}

}  // namespace stria
