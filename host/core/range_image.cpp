#include "host/core/range_image.h"

#include <algorithm>
#include <stdexcept>

namespace stria {

RangeImage make_range_image(int width, int height) {
    RangeImage image;
    image.width = width;
    image.height = height;
    const std::size_t cells = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    image.mask.assign(cells, 0);
    image.points.resize(cells);
    return image;
}

std::size_t valid_count(const RangeImage& image) {
    return static_cast<std::size_t>(
        std::count_if(image.mask.begin(), image.mask.end(), [](std::uint8_t m) { return m != 0; }));
}

Station station_at(const RangeImage& image, double s) {
    const auto& stations = image.stations;
    if (stations.empty())
        throw std::invalid_argument("station_at: the image is orthographic, it has no stations");
    if (stations.size() == 1 || s <= stations.front().s) return stations.front();
    if (s >= stations.back().s) return stations.back();
    const auto after = std::upper_bound(stations.begin(), stations.end(), s,
                                        [](double at, const Station& st) { return at < st.s; });
    const Station& a = *(after - 1);
    const Station& b = *after;
    const double w = (s - a.s) / (b.s - a.s);
    return {s, (1 - w) * a.camera_in_scan + w * b.camera_in_scan,
            (1 - w) * a.laser_in_scan + w * b.laser_in_scan};
}

Eigen::Vector3d direction_to_camera(const RangeImage& image, const RangePoint& point) {
    if (image.stations.empty()) return Eigen::Vector3d::UnitZ();
    return (station_at(image, point.s).camera_in_scan - point.position).normalized();
}

}  // namespace stria
