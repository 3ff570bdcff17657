#include "firmware/stripe/spatial.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "firmware/stripe/option_check.h"
#include "firmware/stripe/row_bands.h"
#include "firmware/stripe/row_peaks.h"
#include "firmware/stripe/saturation.h"

namespace stria {
namespace {

/// True if peak b, at most two rows further, continues the stripe of peak a.
bool continues(const Pulse& a, const Pulse& b) {
    const float reach = std::max(2.0f, 0.5f * (a.width + b.width));
    return std::abs(a.u - b.u) <= reach && a.width < 2 * b.width && b.width < 2 * a.width &&
           a.amplitude < 3 * b.amplitude && b.amplitude < 3 * a.amplitude;
}

/// Rows of the longest chain of peaks through each peak; one missing row is bridged.
std::vector<int> chain_lengths(const std::vector<Pulse>& peaks) {
    const std::size_t n = peaks.size();
    std::vector<int> above(n, 1), below(n, 1);  // of the longest chain that ends / starts here
    const auto row = [&](std::size_t i) { return static_cast<int>(peaks[i].v); };
    std::size_t begin = 0;
    for (std::size_t i = 0; i < n; ++i) {
        while (row(begin) < row(i) - 2) ++begin;
        for (std::size_t k = begin; k < i && row(k) < row(i); ++k)
            if (continues(peaks[k], peaks[i])) above[i] = std::max(above[i], above[k] + 1);
    }
    std::size_t end = n;
    for (std::size_t i = n; i-- > 0;) {
        while (row(end - 1) > row(i) + 2) --end;
        for (std::size_t k = end; k-- > i + 1 && row(k) > row(i);)
            if (continues(peaks[i], peaks[k])) below[i] = std::max(below[i], below[k] + 1);
    }
    for (std::size_t i = 0; i < n; ++i) above[i] += below[i] - 1;
    return above;
}

/// Of each row the peaks on the longest chains, at most `most`, in their old order; none on a chain
/// shorter than `min_rows`. A stripe is long, what looks like one in a row or two is clutter.
void keep_long_chains(std::vector<Pulse>& peaks, int min_rows, int most) {
    const std::vector<int> length = chain_lengths(peaks);
    std::vector<Pulse> kept;
    for (std::size_t begin = 0, end; begin < peaks.size(); begin = end) {
        end = begin;
        while (end < peaks.size() && peaks[end].v == peaks[begin].v) ++end;
        for (std::size_t i = begin; i < end; ++i) {
            if (length[i] < min_rows) continue;
            int better = 0;
            for (std::size_t k = begin; k < end; ++k)
                better += length[k] > length[i] || (length[k] == length[i] && k < i);
            if (better < most) kept.push_back(peaks[i]);
        }
    }
    peaks = std::move(kept);
}

void find_in_rows(const Frame& frame, const SensorNoise& noise, const SpatialOptions& options,
                  int begin, int end, std::vector<Pulse>& peaks) {
    SpatialOptions of_row = options;
    if (options.min_run_rows > 1) of_row.max_peaks_per_row = kMaxPulsesPerCell;  // chains choose
    RowPeakFinder finder(frame.width, frame.full_scale(), noise, of_row);
    for (int y = begin; y < end; ++y) {
        const std::size_t first = peaks.size();
        if (frame.bits > 8)
            finder.find(frame.view16().row(y), peaks);
        else
            finder.find(frame.view8().row(y), peaks);
        for (std::size_t i = first; i < peaks.size(); ++i) {
            peaks[i].v = static_cast<float>(y);
            peaks[i].t_ns = frame.row_time(y);
            peaks[i].laser_id = frame.laser_id;
            peaks[i].exposure_index = frame.exposure_index;
        }
        if (options.accept) {
            const auto of_row_begin = peaks.begin() + static_cast<std::ptrdiff_t>(first);
            peaks.erase(std::remove_if(of_row_begin, peaks.end(),
                                       [&](const Pulse& p) { return !options.accept(p); }),
                        peaks.end());
        }
    }
}

}  // namespace

void SpatialOptions::validate() const {
    const OptionCheck require{"SpatialOptions"};
    require(min_snr > 0, "min_snr", min_snr, "above 0");
    require(min_amplitude_dn >= 0, "min_amplitude_dn", min_amplitude_dn, "0 or more");
    require(max_peaks_per_row >= 1 && max_peaks_per_row <= kMaxPulsesPerCell, "max_peaks_per_row",
            max_peaks_per_row, "1 to 4");
    require(min_width_px >= 0.1, "min_width_px", min_width_px, "0.1 or more");
    require(max_width_px > min_width_px && max_width_px <= 20, "max_width_px", max_width_px,
            "more than min_width_px, at most 20");
    require(max_misfit > 0, "max_misfit", max_misfit, "above 0");
    require(min_run_rows >= 1, "min_run_rows", min_run_rows, "1 or more");
    require(threads >= 1, "threads", threads, "1 or more");
    require(sequence_step >= 1, "sequence_step", sequence_step, "1 or more");
}

std::vector<Pulse> find_peaks(const Frame& frame, const SensorNoise& noise,
                              const SpatialOptions& options) {
    options.validate();
    if (frame.width < kMinRowLength || frame.height < 1) return {};
    const int bands = std::min(options.threads, frame.height);
    std::vector<std::vector<Pulse>> of_band(static_cast<std::size_t>(bands));
    for_row_bands(bands, bands, [&](int first, int last) {
        for (int band = first; band < last; ++band)
            find_in_rows(frame, noise, options, frame.height * band / bands,
                         frame.height * (band + 1) / bands, of_band[band]);
    });
    std::vector<Pulse> peaks = std::move(of_band[0]);
    for (std::size_t band = 1; band < of_band.size(); ++band)
        peaks.insert(peaks.end(), of_band[band].begin(), of_band[band].end());
    if (options.min_run_rows > 1)
        keep_long_chains(peaks, options.min_run_rows, options.max_peaks_per_row);
    return peaks;
}

SpatialAnalyser::SpatialAnalyser(int height, const SensorNoise& noise,
                                 const SpatialOptions& options)
    : height_(height), noise_(noise), options_(options) {
    if (height < 1 || height > kMaxFrameSide)
        throw std::invalid_argument("SpatialAnalyser: height = " + std::to_string(height) +
                                    ": expected 1 to " + std::to_string(kMaxFrameSide));
    options.validate();
}

void SpatialAnalyser::add(const Frame& frame) {
    if (frame.height != height_)
        throw std::invalid_argument("SpatialAnalyser: frame of " + std::to_string(frame.height) +
                                    " rows: expected " + std::to_string(height_));
    if (!follower_.accept(frame, options_.sequence_step)) return;
    counts_.camera_id = frame.camera_id;
    counts_.saturated_samples += count_saturated(frame);
    peaks_of_frame_.push_back(find_peaks(frame, noise_, options_));
}

PulseMap SpatialAnalyser::finish() {
    PulseMap map = std::exchange(counts_, {});
    const std::vector<std::vector<Pulse>> frames = std::exchange(peaks_of_frame_, {});
    map.mode = StripeMode::spatial;
    map.width = static_cast<int>(frames.size());
    map.height = height_;
    map.frames = static_cast<std::uint32_t>(frames.size());
    map.frames_dropped = follower_.dropped();
    map.cell_begin.push_back(0);
    std::vector<std::size_t> next(frames.size(), 0);
    for (int v = 0; v < height_; ++v) {
        for (std::size_t k = 0; k < frames.size(); ++k) {
            const std::vector<Pulse>& peaks = frames[k];
            while (next[k] < peaks.size() && static_cast<int>(peaks[next[k]].v) == v)
                map.pulses.push_back(peaks[next[k]++]);
            map.cell_begin.push_back(static_cast<std::uint32_t>(map.pulses.size()));
        }
    }
    follower_ = {};
    return map;
}

}  // namespace stria
