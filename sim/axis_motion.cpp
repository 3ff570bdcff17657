#include "sim/axis_motion.h"

#include <algorithm>
#include <cmath>

namespace stria {

void AxisMotion::halt(TimeNs now) {
    const double s = position(now);
    while (pieces_.size() > 1 && pieces_.back().begin >= now) pieces_.pop_back();
    Piece& last = pieces_.back();
    if (last.end > now) {
        last.end = std::max(now, last.begin);
        last.s_end = s;
    }
}

void AxisMotion::then_move(TimeNs earliest, double s, double speed) {
    const Piece& last = pieces_.back();
    const TimeNs begin = std::max(earliest, last.end);
    const double seconds = std::abs(s - last.s_end) / speed;
    const auto duration = static_cast<TimeNs>(std::llround(seconds * 1e9));
    pieces_.push_back({begin, begin + duration, last.s_end, s});
}

double AxisMotion::position(TimeNs time) const {
    const auto after =
        std::upper_bound(pieces_.begin(), pieces_.end(), time,
                         [](TimeNs t, const Piece& piece) { return t < piece.begin; });
    if (after == pieces_.begin()) return pieces_.front().s_begin;
    const Piece& piece = *(after - 1);
    if (time >= piece.end) return piece.s_end;
    const double share =
        static_cast<double>(time - piece.begin) / static_cast<double>(piece.end - piece.begin);
    return piece.s_begin + share * (piece.s_end - piece.s_begin);
}

bool AxisMotion::is_moving(TimeNs now) const { return pieces_.back().end > now; }

std::vector<TimeNs> AxisMotion::corners(TimeNs begin, TimeNs end) const {
    std::vector<TimeNs> times;
    for (auto piece = pieces_.rbegin(); piece != pieces_.rend() && piece->end > begin; ++piece)
        for (TimeNs t : {piece->end, piece->begin})
            if (t > begin && t < end) times.push_back(t);
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    return times;
}

std::vector<AxisSample> AxisMotion::samples(TimeNs begin, TimeNs end, TimeNs period) const {
    std::vector<TimeNs> times = corners(begin, end);
    const auto every = [&](TimeNs from, TimeNs to, TimeNs step) {
        for (TimeNs t = (from / step + 1) * step; t < to; t += step) times.push_back(t);
    };
    TimeNs rest_from = begin;
    for (const Piece& piece : pieces_) {
        if (piece.end <= begin || piece.begin >= end) continue;
        every(rest_from, std::max(piece.begin, rest_from), 100 * period);
        every(std::max(piece.begin, begin), std::min(piece.end, end), period);
        rest_from = piece.end;
    }
    every(rest_from, end, 100 * period);
    times.push_back(begin);
    times.push_back(end);
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    std::vector<AxisSample> result;
    result.reserve(times.size());
    for (TimeNs t : times) result.push_back({t, position(t)});
    return result;
}

}  // namespace stria
