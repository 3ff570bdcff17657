#include "host/cli/sheet_views.h"

#include <algorithm>
#include <cmath>

#include "calib/board_shift.h"
#include "calib/detect_board.h"
#include "firmware/stripe/noise_estimate.h"
#include "firmware/stripe/spatial.h"
#include "host/cli/stripe_input.h"
#include "host/core/errors.h"
#include "host/core/frame_image.h"
#include "host/core/short_number.h"
#include "host/geometry/parallel.h"
#include "host/io/image_io.h"

namespace stria {
namespace {

constexpr int kLeastRun = 5;  // rows in a chain: texture rarely makes longer ones

/// DN of no laser light, so that noise below it stays: room for it in 8 bits as in 16.
int pedestal_dn(int bits) { return std::min(64 << (bits - 8), 4096); }

/// A colour photograph's laser light alone: its channel above the greater of the others.
Frame laser_light(const LoadedImage& image, int channel, bool columns) {
    const Image<std::uint16_t>& from = image.pixels;
    const int bits = std::min(image.bits + 1, 16), most = (1 << bits) - 1;
    const int pedestal = pedestal_dn(image.bits);
    Grey16Image light(from.width, from.height);
    for (int y = 0; y < from.height; ++y)
        for (int x = 0; x < from.width; ++x) {
            const int others =
                std::max(from.at(x, y, (channel + 1) % 3), from.at(x, y, (channel + 2) % 3));
            light.at(x, y) = static_cast<std::uint16_t>(
                std::clamp(from.at(x, y, channel) - others + pedestal, 0, most));
        }
    const Frame frame = frame_from_image(light, bits);
    return columns ? transposed(frame) : frame;
}

/// Noise about a pedestal, which the estimate takes for light.
SensorNoise noise_above(int pedestal, const Frame& light) {
    SensorNoise noise = estimate_noise({&light, 1});
    const double read_dn = noise.read_noise_e / noise.gain_e_per_dn;
    noise.read_noise_e =
        noise.gain_e_per_dn * std::sqrt(read_dn * read_dn + pedestal / noise.gain_e_per_dn);
    noise.black_dn = pedestal;
    return noise;
}

/// Pictures searched along their rows, or along their columns.
class StripeSearch {
  public:
    /// @param laser  0 red, 1 green, 2 blue: looked for alone; -1: in the picture as it is
    StripeSearch(const SheetPhotographs& photographs, bool columns, int laser)
        : images_(
              photographs.with_stripe,
              {.channel = photographs.channel, .columns = columns, .off = photographs.laser_off}),
          columns_(columns),
          laser_(laser) {
        if (laser_ < 0) noise_ = images_.estimated_noise();
    }

    std::vector<StripePeak> peaks(std::size_t i) {
        SpatialOptions options;
        options.min_run_rows = kLeastRun;
        options.max_peaks_per_row = kMaxPulsesPerCell;  // the board has bright stretches of its own
        options.threads = thread_count();
        if (laser_ >= 0) {
            const LoadedImage image = read_image(images_.file(i));
            const Frame light = laser_light(image, laser_, columns_);
            const SensorNoise noise = noise_above(pedestal_dn(image.bits), light);
            return stripe_peaks(find_peaks(light, noise, options), columns_);
        }
        const StripeImage image = images_.load(i);
        options.accept = [&](const Pulse& peak) { return image.colour.has(peak); };
        return stripe_peaks(find_peaks(image.frame, noise_, options), columns_);
    }

  private:
    StripeImages images_;
    SensorNoise noise_;
    bool columns_;
    int laser_;
};

/// The channel of the laser's colour in the first picture that shows one; -1 if none does.
int laser_channel(const std::vector<std::string>& files) {
    for (const std::string& file : files) {
        const ColourChannel colour = laser_colour(read_image(file));
        if (colour == ColourChannel::red) return 0;
        if (colour == ColourChannel::green) return 1;
        if (colour == ColourChannel::blue) return 2;
    }
    return -1;
}

std::vector<StripeSearch> searches(const SheetPhotographs& photographs) {
    const bool colour_alone = photographs.laser_off.empty() && photographs.channel == "auto";
    const int laser = colour_alone ? laser_channel(photographs.with_stripe) : -1;
    if (colour_alone && laser < 0)
        throw Error("none of " + std::to_string(photographs.with_stripe.size()) +
                    " pictures shows a laser's colour, which tells the stripe from the board's own "
                    "bright parts: expected --laser-off pictures of the same placements");
    std::vector<StripeSearch> all;
    for (const bool columns : {false, true})
        if (photographs.axis != (columns ? "rows" : "columns"))
            all.emplace_back(photographs, columns, laser);
    return all;
}

GreyImage read_checked(const std::string& file, const CameraModel& camera) {
    GreyImage image = read_grey_image(file);
    if (image.width != camera.width || image.height != camera.height)
        throw Error(file + ": " + std::to_string(image.width) + " x " +
                    std::to_string(image.height) + " px, but the camera has " +
                    std::to_string(camera.width) + " x " + std::to_string(camera.height));
    return image;
}

/// The board in a placement, or why it cannot be used.
Detection board_in(const SheetPhotographs& photographs, std::size_t i, const Board& board,
                   const CameraModel& camera) {
    const GreyImage with_stripe = read_checked(photographs.with_stripe[i], camera);
    if (photographs.laser_off.empty()) return detect_board(with_stripe, board);
    Detection found = detect_board(read_checked(photographs.laser_off[i], camera), board);
    if (!found.found()) return found;
    const auto shift = board_shift_px(found, detect_board(with_stripe, board));
    if (shift && *shift > kMovedPx)
        found.refusal = "moved between the pictures with and without laser: the corners by " +
                        short_number(*shift, 3) + " px";
    return found;
}

[[noreturn]] void refuse_without_board(const SheetPhotographs& photographs, const Board& board,
                                       const std::vector<RefusedPhotograph>& refused) {
    std::string why = "the board " + to_string(board) + " was found in none of " +
                      std::to_string(photographs.with_stripe.size()) + " placements";
    for (const RefusedPhotograph& one : refused) why += "\n  " + one.file + ": " + one.reason;
    throw Error(why);
}

}  // namespace

SheetViews read_sheet_views(const SheetPhotographs& photographs, const Board& board,
                            const CameraModel& camera,
                            const std::function<void(std::size_t)>& on_progress) {
    const auto& files = photographs.with_stripe;
    if (!photographs.laser_off.empty() && photographs.laser_off.size() != files.size())
        throw Error("--laser-off: " + std::to_string(photographs.laser_off.size()) +
                    " pictures, but " + std::to_string(files.size()) +
                    " with the stripe; expected one for each, in the same order");
    for (const std::string& file : files) read_checked(file, camera);
    for (const std::string& file : photographs.laser_off) read_checked(file, camera);
    auto all = searches(photographs);
    SheetViews result;
    for (std::size_t i = 0; i < files.size(); ++i) {
        Detection found = board_in(photographs, i, board, camera);
        if (found.found()) {
            SheetView& view = result.views.emplace_back();
            view.corners = {files[i], std::move(found.ids), std::move(found.pixels), {}};
            for (StripeSearch& search : all) view.peaks.push_back(search.peaks(i));
        } else {
            result.refused.push_back({files[i], found.refusal});
        }
        on_progress(i + 1);
    }
    if (result.views.empty()) refuse_without_board(photographs, board, result.refused);
    return result;
}

}  // namespace stria
