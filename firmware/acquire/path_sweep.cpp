#include "firmware/acquire/path_sweep.h"

#include <algorithm>
#include <limits>

namespace stria {
namespace {

constexpr std::size_t kMostText = 1000;  // bytes about the tables; a feature takes 4096

bool is_printable(const std::string& text) {
    return std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

}  // namespace

const PathTable* find_paths(const AcquireOptions& options, std::uint8_t laser_id) {
    const auto found =
        std::find_if(options.path_tables.begin(), options.path_tables.end(),
                     [=](const PathTable& table) { return table.laser_id == laser_id; });
    return found == options.path_tables.end() ? nullptr : &*found;
}

bool follows_paths(const ScanPlan& plan, const AcquireOptions& options) {
    return plan.mode == StripeMode::spacetime && plan.record != RecordWhat::frames &&
           !options.spacetime_per_pixel;
}

std::vector<const PathTable*> paths_followed(const ScanPlan& plan, const AcquireOptions& options) {
    if (!follows_paths(plan, options)) return {};
    std::vector<const PathTable*> tables;
    for (const std::uint8_t laser : plan.lasers) {
        tables.push_back(find_paths(options, laser));
        if (tables.back() == nullptr) return {};
    }
    return tables;
}

std::string check_paths(const PathTable& table, const Devices& devices,
                        const AcquireOptions& options) {
    if (options.spacetime_per_pixel)
        return "paths: the pixels of this machine are surface points, it follows no image paths";
    const CameraInfo camera = devices.camera.info();
    const auto size = [](int width, int height) {
        return std::to_string(width) + " x " + std::to_string(height);
    };
    if (table.image_width != camera.width || table.image_height != camera.height)
        return "paths: of an image of " + size(table.image_width, table.image_height) +
               ": expected the camera's " + size(camera.width, camera.height);
    const std::size_t lasers = 1 + devices.further_lasers.size();
    if (table.laser_id >= lasers)
        return "paths: of laser " + std::to_string(table.laser_id) + ": expected 0 to " +
               std::to_string(lasers - 1);
    if (!is_printable(table.model_hash)) return "paths: model_hash: expected printable ASCII";
    return validate(table);
}

std::string describe_paths(const AcquireOptions& options) {
    if (options.spacetime_per_pixel) return "pixels";
    if (options.path_tables.empty())
        return "none: no image paths have been sent since the client took control";
    std::string text;
    for (const PathTable& table : options.path_tables)
        text += (text.empty() ? "laser " : ", laser ") + std::to_string(table.laser_id) +
                ": model " + table.model_hash.substr(0, 64);
    if (text.size() > kMostText) text = text.substr(0, kMostText) + " ...";
    return text;
}

Status PathSweep::add(const Frame& frame, const AxisLog& log) {
    waiting_.add(frame);
    if (!log.samples.empty()) analyse_to(log.samples.back().t_ns, log);
    if (waiting_.count() - waiting_.first() <= kMostWaiting) return {};
    return Failure{"the axis log lags behind the camera: " + std::to_string(kMostWaiting) +
                   " frames wait for the position at " +
                   std::to_string(waiting_.at(waiting_.first()).row_time(0)) + " ns"};
}

/// Frames before the first position of the log have none and are left out.
void PathSweep::analyse_to(TimeNs end_ns, const AxisLog& log) {
    int next = waiting_.first();
    for (; next < waiting_.count() && waiting_.at(next).row_time(0) < end_ns; ++next)
        if (const auto axis = position_at(log, waiting_.at(next).row_time(0)))
            analyser_.add(waiting_.at(next), *axis);
    waiting_.release_before(next);
}

PulseMap PathSweep::finish(const AxisLog& log) {
    analyse_to(std::numeric_limits<TimeNs>::max(), log);
    return analyser_.finish();
}

}  // namespace stria
