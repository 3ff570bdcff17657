#include "firmware/core/image_paths.h"

#include <algorithm>
#include <cmath>

#include "firmware/core/frame.h"

namespace stria {
namespace {

constexpr std::size_t kLongestHash = 4096;  // bytes

std::string wrong(const char* field, double value, const std::string& bound) {
    return std::string(field) + " = " + std::to_string(value) + ": expected " + bound;
}

std::string check_columns(const PathTable& table, std::size_t nodes) {
    for (const auto* column :
         {&table.du_ds, &table.dv_ds, &table.d2u_ds2, &table.d2v_ds2, &table.width_s}) {
        if (column->size() != nodes)
            return wrong("path column", static_cast<double>(column->size()),
                         std::to_string(nodes) + " numbers");
        for (const float value : *column)
            if (!std::isfinite(value)) return "path column: expected finite numbers";
    }
    if (table.valid.size() != nodes)
        return wrong("valid", static_cast<double>(table.valid.size()),
                     std::to_string(nodes) + " numbers");
    for (std::size_t i = 0; i < nodes; ++i) {
        if (table.valid[i] > 1) return wrong("valid", table.valid[i], "0 or 1");
        if (table.valid[i] == 1 && !(table.width_s[i] > 0))
            return wrong("width_s", table.width_s[i], "above 0 where the node is valid");
    }
    return {};
}

}  // namespace

std::optional<ImagePath> path_at(const PathTable& table, double u, double v) {
    if (!(u >= 0 && v >= 0 && u <= table.image_width - 1 && v <= table.image_height - 1))
        return std::nullopt;
    const double x = u * (table.nodes_x - 1) / std::max(table.image_width - 1, 1);
    const double y = v * (table.nodes_y - 1) / std::max(table.image_height - 1, 1);
    const int column = std::min(static_cast<int>(x), table.nodes_x - 2);
    const int row = std::min(static_cast<int>(y), table.nodes_y - 2);
    const double fx = x - column, fy = y - row;
    ImagePath path;
    double speed = 0;
    for (int k = 0; k < 4; ++k) {
        const int right = k & 1, down = k >> 1;
        const auto node =
            static_cast<std::size_t>(row + down) * static_cast<std::size_t>(table.nodes_x) +
            static_cast<std::size_t>(column + right);
        if (table.valid[node] == 0) return std::nullopt;
        const double weight = (right ? fx : 1 - fx) * (down ? fy : 1 - fy);
        path.du += weight * table.du_ds[node];
        path.dv += weight * table.dv_ds[node];
        path.ddu += weight * table.d2u_ds2[node];
        path.ddv += weight * table.d2v_ds2[node];
        speed += weight / table.width_s[node];  // widths have a pole where points stand still
    }
    path.width_s = 1 / speed;
    return path;
}

std::string validate(const PathTable& table) {
    const std::string sides = "1 to " + std::to_string(kMaxFrameSide);
    const std::string nodes = "2 to " + std::to_string(kMaxPathNodes);
    const auto outside = [](int value, int low, int high) { return value < low || value > high; };
    if (outside(table.image_width, 1, kMaxFrameSide))
        return wrong("image_width", table.image_width, sides);
    if (outside(table.image_height, 1, kMaxFrameSide))
        return wrong("image_height", table.image_height, sides);
    if (outside(table.nodes_x, 2, kMaxPathNodes)) return wrong("nodes_x", table.nodes_x, nodes);
    if (outside(table.nodes_y, 2, kMaxPathNodes)) return wrong("nodes_y", table.nodes_y, nodes);
    if (table.model_hash.size() > kLongestHash)
        return wrong("model_hash", static_cast<double>(table.model_hash.size()),
                     "at most " + std::to_string(kLongestHash) + " bytes");
    return check_columns(
        table, static_cast<std::size_t>(table.nodes_x) * static_cast<std::size_t>(table.nodes_y));
}

}  // namespace stria
