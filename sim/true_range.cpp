#include "sim/true_range.h"

#include <algorithm>
#include <cmath>

#include "firmware/core/pulse.h"
#include "host/geometry/parallel.h"
#include "sim/beam.h"

namespace stria {
namespace {

RangePoint point_from(const SurfaceHit& hit, const Eigen::Vector3d& camera_in_world, double s) {
    RangePoint point;
    point.position = hit.point;
    point.normal = hit.normal;
    point.error_direction = (hit.point - camera_in_world).normalized().cast<float>();
    point.intensity = hit.albedo;
    point.s = s;
    return point;
}

Station station_for(const Channel& channel, double s) {
    const Rigid3 scan = scan_from_camera(channel, s);
    return {s, scan.translation, scan * sheet_at(channel, s).apex};
}

/// One image row of a rail or table at one s: where rays and sheet's centre and surface meet.
class RowOfFrame {
  public:
    RowOfFrame(const Scene& scene, const SceneGeometry& geometry, const Beam& beam, double s)
        : scene_(scene), geometry_(geometry), beam_(beam), head_(head_pose(scene.channel, s)) {}

    std::vector<SurfaceHit> lit_points(int row) const {
        const auto width = static_cast<std::size_t>(scene_.channel.camera.width);
        std::vector<Eigen::Vector3d> directions(width);
        std::vector<SurfaceHit> hits(width);
        for (std::size_t x = 0; x < width; ++x) directions[x] = ray(static_cast<double>(x), row);
        geometry_.first_hits(head_.world_from_camera.translation, directions, hits);
        std::vector<SurfaceHit> found;
        double before = 0;
        for (std::size_t x = 0; x < width; ++x) {
            const double distance = hits[x].object < 0 ? 0 : distance_of(hits[x]);
            if (x > 0 && hits[x].object >= 0 && hits[x - 1].object >= 0 && before * distance <= 0)
                add_crossing(static_cast<double>(x) - 1, row, before, found);
            before = distance;
        }
        return found;
    }

  private:
    Eigen::Vector3d ray(double u, double v) const {
        return head_.world_from_camera.rotation * ray_through(scene_.channel.camera, {u, v});
    }
    double distance_of(const SurfaceHit& hit) const {
        return signed_distance(scene_.channel.sheet, head_.camera_from_world * hit.point);
    }
    /// Halves [u, u + 1] until the crossing is found; a jump in depth is none.
    void add_crossing(double u, int row, double at_u, std::vector<SurfaceHit>& found) const {
        double low = u, high = u + 1;
        SurfaceHit hit;
        double distance = 0;
        for (int i = 0; i < 40; ++i) {
            const double middle = (low + high) / 2;
            hit = geometry_.first_hit(head_.world_from_camera.translation, ray(middle, row));
            if (hit.object < 0) return;
            distance = distance_of(hit);
            if (std::abs(distance) < 1e-9) break;
            (distance * at_u > 0 ? low : high) = middle;
        }
        if (std::abs(distance) > 1e-6) return;
        const BeamAtPoint light = beam_.beside(hit, head_);
        if (light.rate > 0 && !geometry_.is_occluded(hit, light.light_in_world))
            found.push_back(hit);
    }

    const Scene& scene_;
    const SceneGeometry& geometry_;
    const Beam& beam_;
    HeadPose head_;
};

}  // namespace

RangeImage true_range_swept(const Scene& scene, const SceneGeometry& geometry) {
    const CameraModel& camera = scene.channel.camera;
    const Beam beam(scene);
    const Rigid3 scan = scan_from_camera(scene.channel, 0);
    RangeImage image = make_range_image(camera.width, camera.height);
    image.kind = MachineKind::swept;
    const auto fill_row = [&](int y) {
        std::vector<Eigen::Vector3d> directions;
        for (int x = 0; x < camera.width; ++x)
            directions.push_back(scan.rotation * ray_through(camera, Eigen::Vector2d(x, y)));
        std::vector<SurfaceHit> hits(directions.size());
        geometry.first_hits(scan.translation, directions, hits);
        for (int x = 0; x < camera.width; ++x) {
            const SurfaceHit& hit = hits[static_cast<std::size_t>(x)];
            if (hit.object < 0) continue;
            const auto light = beam.passing(hit, 0);
            if (!light || light->rate <= 0 || light->position < scene.axis.min ||
                light->position > scene.axis.max ||
                geometry.is_occluded(hit, light->light_in_world))
                continue;
            const std::size_t cell = image.cell(x, y);
            image.mask[cell] = 1;
            image.points[cell] = point_from(hit, scan.translation, light->position);
        }
    };
    parallel_for_blocks(static_cast<std::size_t>(camera.height), 8,
                        [&](std::size_t begin, std::size_t end) {
                            for (std::size_t y = begin; y < end; ++y) fill_row(static_cast<int>(y));
                        });
    constexpr int kStations = 65;
    for (int i = 0; i < kStations; ++i)
        image.stations.push_back(
            station_for(scene.channel,
                        scene.axis.min + (scene.axis.max - scene.axis.min) * i / (kStations - 1)));
    return image;
}

RangeImage true_range_of_frames(const Scene& scene, const SceneGeometry& geometry,
                                std::span<const double> frame_s) {
    const int height = scene.channel.camera.height;
    const Beam beam(scene);
    RangeImage image = make_range_image(static_cast<int>(frame_s.size()), height);
    image.kind = scene.channel.axis.kind;
    std::vector<std::vector<FurtherReturn>> further(frame_s.size());
    parallel_for_blocks(frame_s.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const RowOfFrame rows(scene, geometry, beam, frame_s[k]);
            const Eigen::Vector3d eye = scan_from_camera(scene.channel, frame_s[k]).translation;
            for (int v = 0; v < height; ++v) {
                const std::size_t cell = image.cell(static_cast<int>(k), v);
                std::uint8_t number = 0;
                for (const SurfaceHit& hit : rows.lit_points(v)) {
                    const RangePoint point = point_from(hit, eye, frame_s[k]);
                    if (number == 0) {
                        image.mask[cell] = 1;
                        image.points[cell] = point;
                    } else if (number < kMaxPulsesPerCell) {
                        further[k].push_back({static_cast<std::uint32_t>(cell), number, point});
                    }
                    ++number;
                }
            }
        }
    });
    for (const auto& of_frame : further)
        image.further.insert(image.further.end(), of_frame.begin(), of_frame.end());
    std::vector<double> sorted(frame_s.begin(), frame_s.end());
    std::sort(sorted.begin(), sorted.end());
    for (double s : sorted)
        if (image.stations.empty() || s > image.stations.back().s)
            image.stations.push_back(station_for(scene.channel, s));
    return image;
}

}  // namespace stria
