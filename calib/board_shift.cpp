#include "calib/board_shift.h"

#include <algorithm>

#include "firmware/core/median.h"

namespace stria {
namespace {

double median_shift(const std::vector<Eigen::Vector2d>& before,
                    const std::vector<Eigen::Vector2d>& after) {
    std::vector<double> shifts;
    for (std::size_t i = 0; i < before.size(); ++i) shifts.push_back((before[i] - after[i]).norm());
    return median(std::move(shifts));
}

}  // namespace

std::optional<double> board_shift_px(const Detection& before, const Detection& after) {
    if (!before.found() || !after.found()) return std::nullopt;
    std::vector<Eigen::Vector2d> first, second;
    for (std::size_t i = 0; i < before.ids.size(); ++i) {
        const auto at = std::lower_bound(after.ids.begin(), after.ids.end(), before.ids[i]);
        if (at == after.ids.end() || *at != before.ids[i]) continue;
        first.push_back(before.pixels[i]);
        second.push_back(after.pixels[static_cast<std::size_t>(at - after.ids.begin())]);
    }
    if (first.size() < 4) return std::nullopt;
    const double as_numbered = median_shift(first, second);
    std::reverse(second.begin(), second.end());
    return std::min(as_numbered, median_shift(first, second));
}

}  // namespace stria
