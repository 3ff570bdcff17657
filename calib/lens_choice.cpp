#include "calib/lens_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/core/errors.h"

namespace stria {
namespace {

constexpr std::size_t kParts = 3, kFewestViews = 6;
constexpr double kStandardErrors = 2;
constexpr double kLeastRmsPx = 1e-6;  ///< of noise-free corners less is rounding
constexpr LensKind kLenses[] = {LensKind::pinhole, LensKind::brown5, LensKind::rational8};

CameraCalibrationOptions solve_with(LensKind lens) {
    CameraCalibrationOptions options;
    options.lens = lens;
    options.shared_errors = false;
    return options;
}

/// The views and corners that the first of the models from the richest down keeps.
std::vector<CameraView> usable_views(const std::vector<CameraView>& views, const Board& board,
                                     int width, int height) {
    std::string why;
    for (auto lens = std::rbegin(kLenses); lens != std::rend(kLenses); ++lens) {
        CameraCalibration found;
        try {
            found = calibrate_camera(views, board, width, height, solve_with(*lens));
        } catch (const Error& error) {
            why = error.what();
            continue;
        }
        std::vector<CameraView> usable;
        for (std::size_t v = 0; v < views.size(); ++v) {
            if (!found.views[v].rejected.empty()) continue;
            const auto& left_out = found.views[v].ids_rejected;
            CameraView kept;
            kept.name = views[v].name;
            for (std::size_t i = 0; i < views[v].ids.size(); ++i) {
                if (std::find(left_out.begin(), left_out.end(), views[v].ids[i]) != left_out.end())
                    continue;
                kept.ids.push_back(views[v].ids[i]);
                kept.pixels.push_back(views[v].pixels[i]);
                if (!views[v].weights.empty()) kept.weights.push_back(views[v].weights[i]);
            }
            usable.push_back(std::move(kept));
        }
        return usable;
    }
    throw Error("no lens model can be solved: " + why);
}

/// Rms (px) of the views, each by the camera of the other parts.
std::vector<double> held_out_rms(const std::vector<CameraView>& views, const Board& board,
                                 int width, int height, LensKind lens) {
    std::vector<double> rms(views.size());
    for (std::size_t part = 0; part < kParts; ++part) {
        std::vector<CameraView> others;
        for (std::size_t v = 0; v < views.size(); ++v)
            if (v % kParts != part) others.push_back(views[v]);
        const CameraModel camera =
            calibrate_camera(others, board, width, height, solve_with(lens)).camera;
        for (std::size_t v = part; v < views.size(); v += kParts) {
            const auto pose = board_pose(camera, views[v], board);
            if (!pose) throw Error(views[v].name + ": its board has no pose for that camera");
            rms[v] = view_rms_px(camera, *pose, views[v], board);
        }
    }
    return rms;
}

double mean(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}

}  // namespace

CameraModel with_lens(CameraModel camera, LensKind lens) {
    camera.kind = lens;
    std::fill(camera.distortion.begin() + distortion_count(lens), camera.distortion.end(), 0.0);
    return camera;
}

LensChoice choose_lens(const std::vector<CameraView>& views, const Board& board, int width,
                       int height) {
    const std::vector<CameraView> usable = usable_views(views, board, width, height);
    if (usable.size() < kFewestViews)
        throw Error("a lens model can be chosen by " + std::to_string(kFewestViews) +
                    " usable views or more; there are " + std::to_string(usable.size()) +
                    ": expected more views, or the model stated");
    LensChoice choice;
    std::vector<std::vector<double>> logs;
    double least = std::numeric_limits<double>::infinity();
    std::size_t best = 0;
    for (const LensKind lens : kLenses) {
        LensTrial trial;
        trial.lens = lens;
        logs.emplace_back();
        try {
            double squares = 0;
            for (const double rms : held_out_rms(usable, board, width, height, lens)) {
                squares += rms * rms / static_cast<double>(usable.size());
                logs.back().push_back(std::log(std::max(rms, kLeastRmsPx)));
            }
            trial.held_out_rms_px = std::sqrt(squares);
            if (mean(logs.back()) < least) {
                least = mean(logs.back());
                best = choice.trials.size();
            }
        } catch (const Error& error) {
            trial.failed = error.what();
        }
        choice.trials.push_back(trial);
    }
    if (!std::isfinite(least))
        throw Error("no lens model can be solved from two thirds of the views: " +
                    choice.trials.back().failed);
    bool chosen = false;
    for (std::size_t k = 0; k < choice.trials.size(); ++k) {
        LensTrial& trial = choice.trials[k];
        if (!trial.failed.empty()) continue;
        std::vector<double> worse = logs[k];
        for (std::size_t v = 0; v < worse.size(); ++v) worse[v] -= logs[best][v];
        trial.worse_by_log = mean(worse);
        double scatter = 0;
        for (const double one : worse) scatter += std::pow(one - trial.worse_by_log, 2);
        const double count = static_cast<double>(worse.size());
        trial.worse_by_sigma_log = std::sqrt(scatter / (count - 1) / count);
        if (chosen || trial.worse_by_log > kStandardErrors * trial.worse_by_sigma_log) continue;
        choice.lens = trial.lens;
        chosen = true;
    }
    return choice;
}

}  // namespace stria
