// Detection of the fast kernels, for one instruction set; included once for each by
// fast_kernels.cpp.
#if defined(STRIA_FAST_DETECT_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef STRIA_FAST_DETECT_INL
#undef STRIA_FAST_DETECT_INL
#else
#define STRIA_FAST_DETECT_INL
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <vector>

#include "firmware/stripe/fast_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace stria::fast::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

/// For processors without any of the instruction sets.
RowState AdvanceRow(const std::uint8_t* const* rows, int width, const RowPlanes& planes,
                    const DetectionLevels& levels, const WindowLimits& limits, std::uint8_t number,
                    std::vector<Closed>& others) {
    return advance_row_plainly(rows, kBatch, width, planes, levels, limits, number, others);
}

void SetBackgrounds(const std::uint8_t* const* rows, int width, const RowPlanes& planes,
                    const DetectionLevels& levels) {
    set_backgrounds_plainly(rows, kBatch, 0, width, planes, levels);
}

#else

static_assert(sizeof(std::uint32_t) * kLanes == kPadding);

using D8 = hn::CappedTag<std::uint8_t, kPadding>;
using D16 = hn::Repartition<std::uint16_t, D8>;
using V8 = hn::Vec<D8>;
using V16 = hn::Vec<D16>;

HWY_INLINE bool any_of_lanes(const std::uint8_t* plane) {
    std::uint64_t low, high;
    static_assert(kLanes == 2 * sizeof(low));
    std::memcpy(&low, plane, sizeof(low));
    std::memcpy(&high, plane + sizeof(low), sizeof(high));
    return (low | high) != 0;
}

/// Bytes of even and of odd pixels, each widened.
struct Halves {
    V16 even, odd;
};

HWY_INLINE Halves halves_of(V8 high, V8 low) {
    const D16 d16;
    const V16 h = hn::BitCast(d16, high), l = hn::BitCast(d16, low);
    const V16 byte = hn::Set(d16, 0xff);
    return {hn::Or(hn::ShiftLeft<8>(h), hn::And(l, byte)),
            hn::Or(hn::AndNot(byte, h), hn::ShiftRight<8>(l))};
}

HWY_INLINE V8 high_bytes(const Halves& v) {
    const D16 d16;
    return hn::BitCast(D8(),
                       hn::Or(hn::ShiftRight<8>(v.even), hn::AndNot(hn::Set(d16, 0xff), v.odd)));
}

HWY_INLINE V8 low_bytes(const Halves& v) {
    const D16 d16;
    return hn::BitCast(D8(), hn::Or(hn::And(v.even, hn::Set(d16, 0xff)), hn::ShiftLeft<8>(v.odd)));
}

HWY_INLINE hn::Mask<D8> at_least(V8 a, V8 b) { return hn::Eq(hn::Max(a, b), a); }

/// DetectionLevels in registers.
class Levels {
  public:
    explicit Levels(const DetectionLevels& levels) {
        for (int i = 0; i < DetectionLevels::kSegments; ++i) {
            const auto s = static_cast<std::size_t>(i);
            base_low_[s] = static_cast<std::uint8_t>(levels.base()[s]);
            base_high_[s] = static_cast<std::uint8_t>(levels.base()[s] >> 8);
            rise_low_[s] = static_cast<std::uint8_t>(levels.rise()[s]);
            rise_high_[s] = static_cast<std::uint8_t>(levels.rise()[s] >> 8);
        }
    }

    /// What samples must exceed backgrounds by, 1/256 DN.
    HWY_INLINE Halves margins(const Halves& background) const {
        const V8 segment = hn::ShiftRight<4>(high_bytes(background));
        const Halves base = halves_of(look_up(base_high_, segment), look_up(base_low_, segment));
        const Halves rise = halves_of(look_up(rise_high_, segment), look_up(rise_low_, segment));
        return {margin_of(background.even, base.even, rise.even),
                margin_of(background.odd, base.odd, rise.odd)};
    }
    /// Thresholds (DN) of backgrounds.
    HWY_INLINE V8 thresholds(const Halves& background) const {
        const Halves margin = margins(background);
        return high_bytes({hn::SaturatedAdd(background.even, margin.even),
                           hn::SaturatedAdd(background.odd, margin.odd)});
    }

  private:
    using Table = std::array<std::uint8_t, DetectionLevels::kSegments>;

    static HWY_INLINE V8 look_up(const Table& table, V8 index) {
        const D8 d8;
        return hn::TableLookupBytes(hn::LoadDup128(d8, table.data()), index);
    }
    static HWY_INLINE V16 margin_of(V16 background, V16 base, V16 rise) {
        return hn::Add(base, hn::MulHigh(hn::ShiftLeft<4>(background), rise));
    }

    alignas(16) Table base_low_, base_high_, rise_low_, rise_high_;
};

/// DetectionLevels::follow for kBatch samples; `level` is the threshold.
HWY_INLINE V16 follow(V16 background, V16 sum, V16 level) {
    const V16 mean = hn::ShiftLeft<5>(sum);
    const V16 room = hn::SaturatedSub(hn::ShiftLeft<8>(level), background);
    const V16 up = hn::SaturatedSub(mean, background);
    const V16 down = hn::SaturatedSub(background, mean);
    const V16 step = hn::Sub(hn::ShiftRight<2>(hn::Min(up, room)), hn::ShiftRight<2>(down));
    return hn::IfThenElse(hn::Gt(down, room), mean, hn::Add(background, step));
}

/// One block of pixels, D8's lanes, whose light is or may be above the threshold: frame by frame.
class Block {
  public:
    Block(const RowPlanes& planes, int x, V8 threshold, const WindowLimits& limits,
          std::uint8_t number, std::vector<Closed>& others)
        : planes_(planes),
          x_(x),
          threshold_(threshold),
          limits_(limits),
          number_(number),
          others_(others) {}

    HWY_INLINE void advance(const std::uint8_t* const* rows, int offset) {
        const D8 d;
        const V8 one = hn::Set(d, 1), zero = hn::Zero(d);
        V8 age = hn::Load(d, planes_.age + x_), quiet = hn::Load(d, planes_.quiet + x_);
        V8 waiting = hn::Load(d, planes_.waiting + x_), end = hn::Load(d, planes_.waiting_end + x_);
        auto closed = hn::Ne(zero, zero);  // windows that wait since this batch
        const auto longest =
            hn::Set(d, static_cast<std::uint8_t>(std::min(limits_.max_pulse_frames, 255)));
        const auto history =
            hn::Set(d, static_cast<std::uint8_t>(std::min(limits_.history_frames, 255)));
        for (int k = 0; k < kBatch; ++k) {
            const auto above = hn::Gt(hn::LoadU(d, rows[k] + offset), threshold_);
            const auto lit = hn::Or(above, hn::Ne(age, zero));
            quiet = hn::IfThenZeroElse(above, hn::Add(quiet, one));
            age = hn::IfThenElseZero(lit, hn::Add(age, one));
            const V8 frames = hn::Sub(age, one);  // since the first one; 255 where there is none
            const auto too_long = hn::And(lit, at_least(frames, longest));
            const V8 last = hn::Sub(frames, quiet);
            const V8 tail = hn::Min(hn::Add(hn::ShiftRight<1>(last), hn::Set(d, 4)), history);
            const auto ended =
                hn::AndNot(hn::Or(above, too_long), hn::And(lit, at_least(quiet, tail)));
            if (HWY_UNLIKELY(!hn::AllFalse(d, too_long))) {
                keep_levels(closed);
                closed = hn::Ne(zero, zero);
                start_anew(too_long, rows[k] + offset);
            }
            // Not asked first whether any has ended: that is as often wrongly guessed.
            const auto number = static_cast<std::uint8_t>(number_ + k + 1);
            const auto taken = hn::And(ended, hn::Ne(waiting, zero));
            if (HWY_UNLIKELY(!hn::AllFalse(d, taken))) report(taken, last, number);
            const auto free = hn::AndNot(taken, ended);
            waiting = hn::IfThenElse(free, hn::Add(last, one), waiting);
            end = hn::IfThenElse(free, hn::Set(d, number), end);
            closed = hn::Or(closed, free);
            age = hn::IfThenZeroElse(hn::Or(too_long, ended), age);
        }
        hn::Store(age, d, planes_.age + x_);
        hn::Store(quiet, d, planes_.quiet + x_);
        if (!hn::AllFalse(d, hn::Ne(waiting, zero))) {
            hn::Store(waiting, d, planes_.waiting + x_);
            hn::Store(end, d, planes_.waiting_end + x_);
            keep_levels(closed);
        }
        flag(age, waiting);
    }

  private:
    /// No pulse but another light: the background is what is seen now.
    HWY_NOINLINE void start_anew(hn::Mask<D8> which, const std::uint8_t* row) {
        const D8 d;
        const V8 high = hn::Load(d, planes_.background_high + x_);
        const V8 low = hn::Load(d, planes_.background_low + x_);
        hn::Store(hn::IfThenElse(which, hn::LoadU(d, row), high), d, planes_.background_high + x_);
        hn::Store(hn::IfThenZeroElse(which, low), d, planes_.background_low + x_);
    }

    HWY_INLINE void flag(V8 age, V8 waiting) const {
        alignas(kPadding) std::uint8_t ages[kPadding], waits[kPadding];
        const int lanes = static_cast<int>(hn::Lanes(D8()));
        hn::Store(age, D8(), ages);
        hn::Store(waiting, D8(), waits);
        for (int i = 0; i < lanes; i += kLanes) {
            planes_.lower(x_ + i, kOpen);
            if (any_of_lanes(ages + i)) planes_.raise(x_ + i, kOpen);
            if (any_of_lanes(waits + i)) planes_.raise(x_ + i, kWaiting);
        }
    }

    /// Backgrounds and thresholds of windows that wait from now on.
    HWY_INLINE void keep_levels(hn::Mask<D8> closed) const {
        const D8 d;
        put(hn::Load(d, planes_.background_high + x_), closed, planes_.waiting_high);
        put(hn::Load(d, planes_.background_low + x_), closed, planes_.waiting_low);
        put(threshold_, closed, planes_.waiting_threshold);
    }

    /// Windows that closed before the frame of that number while others of their pixels wait.
    HWY_NOINLINE void report(hn::Mask<D8> taken, V8 last, std::uint8_t end) const {
        const D8 d;
        alignas(kPadding) std::uint8_t lasts[kPadding];
        std::uint64_t bits = 0;
        std::array<std::uint8_t, 8> bytes{};
        alignas(kPadding) std::uint8_t thresholds[kPadding];
        hn::Store(last, d, lasts);
        hn::Store(threshold_, d, thresholds);
        hn::StoreMaskBits(d, taken, bytes.data());
        std::memcpy(&bits, bytes.data(), sizeof(bits));  // little endian, as every target here
        for (; bits != 0; bits &= bits - 1) {
            const int i = std::countr_zero(bits);
            others_.push_back(planes_.closed(x_ + i, thresholds[i], lasts[i], end));
        }
    }

    HWY_INLINE void put(V8 value, hn::Mask<D8> where, std::uint8_t* plane) const {
        const D8 d;
        hn::Store(hn::IfThenElse(where, value, hn::Load(d, plane + x_)), d, plane + x_);
    }

    const RowPlanes& planes_;
    const int x_;
    const V8 threshold_;
    const WindowLimits& limits_;
    const std::uint8_t number_;
    std::vector<Closed>& others_;
};

/// True if there is light at some of the pixels [x, x + lanes).
HWY_INLINE bool is_open(const RowPlanes& planes, int x) {
    std::uint32_t flags = 0;
    std::memcpy(&flags, planes.flags + x / kLanes, hn::Lanes(D8()) / kLanes);
    return (flags & (kOpen * 0x01010101u)) != 0;
}

/// Asks memory for what the row below will need of kPadding pixels from x on; a row has `width`
/// samples. Below the last row there is nothing, and asking for it does no harm.
HWY_INLINE void prefetch_below(const std::uint8_t* const* rows, int x, int width,
                               const RowPlanes& planes) {
    const auto below_of = [](const std::uint8_t* from, std::ptrdiff_t distance) {
        return reinterpret_cast<const void*>(reinterpret_cast<std::uintptr_t>(from) +
                                             static_cast<std::uintptr_t>(distance));
    };
    // Samples into the second cache: the first one cannot wait for so many lines at a time.
    for (int k = 0; k < kBatch; ++k) __builtin_prefetch(below_of(rows[k], x + width), 0, 2);
    const std::ptrdiff_t stride = planes.background_low - planes.background_high;
    const std::ptrdiff_t below = static_cast<std::ptrdiff_t>(RowPlanes::kCount) * stride + x;
    __builtin_prefetch(below_of(planes.background_high, below));
    __builtin_prefetch(below_of(planes.background_low, below));
}

/// Pixels [x, x + lanes) of the row, whose samples are at `offset` in `rows`.
HWY_INLINE std::uint32_t advance_block(const std::uint8_t* const* rows, int offset, int x,
                                       const RowPlanes& planes, const Levels& levels,
                                       const WindowLimits& limits, std::uint8_t number,
                                       std::vector<Closed>& others, V8& oldest) {
    const D8 d;
    const D16 d16;
    V8 highest = hn::LoadU(d, rows[0] + offset);
    V16 all = hn::BitCast(d16, highest);  // even + 256 odd, modulo 65536
    V16 odd = hn::ShiftRight<8>(all);
    for (int k = 1; k < kBatch; ++k) {
        const V8 samples = hn::LoadU(d, rows[k] + offset);
        const V16 pairs = hn::BitCast(d16, samples);
        highest = hn::Max(highest, samples);
        all = hn::Add(all, pairs);
        odd = hn::Add(odd, hn::ShiftRight<8>(pairs));
    }
    const Halves sum = {hn::Sub(all, hn::ShiftLeft<8>(odd)), odd};
    std::uint32_t saturated = 0;
    const V8 full = hn::Set(d, 255);
    if (HWY_UNLIKELY(!hn::AllFalse(d, hn::Eq(highest, full))))
        for (int k = 0; k < kBatch; ++k)
            saturated += static_cast<std::uint32_t>(
                hn::CountTrue(d, hn::Eq(hn::LoadU(d, rows[k] + offset), full)));

    const V8 high = hn::Load(d, planes.background_high + x);
    const V8 low = hn::Load(d, planes.background_low + x);
    const Halves before = halves_of(high, low);
    const V8 threshold = levels.thresholds(before);
    const Halves level = halves_of(hn::Zero(d), threshold);
    if (HWY_LIKELY(hn::AllFalse(d, hn::Gt(highest, threshold)) && !is_open(planes, x))) {
        const Halves moved = {follow(before.even, sum.even, level.even),
                              follow(before.odd, sum.odd, level.odd)};
        hn::Store(high_bytes(moved), d, planes.background_high + x);
        hn::Store(low_bytes(moved), d, planes.background_low + x);
        return saturated;
    }
    Block(planes, x, threshold, limits, number, others).advance(rows, offset);
    const V8 age = hn::Load(d, planes.age + x);
    oldest = hn::Max(oldest, age);
    // Where another light has come, the background is new.
    const V8 high_now = hn::Load(d, planes.background_high + x);
    const V8 low_now = hn::Load(d, planes.background_low + x);
    const Halves now = halves_of(high_now, low_now);
    const Halves level_now = halves_of(hn::Zero(d), levels.thresholds(now));
    const Halves moved = {follow(now.even, sum.even, level_now.even),
                          follow(now.odd, sum.odd, level_now.odd)};
    const auto closed = hn::Eq(age, hn::Zero(d));
    hn::Store(hn::IfThenElse(closed, high_bytes(moved), high_now), d, planes.background_high + x);
    hn::Store(hn::IfThenElse(closed, low_bytes(moved), low_now), d, planes.background_low + x);
    return saturated;
}

RowState AdvanceRow(const std::uint8_t* const* rows, int width, const RowPlanes& planes,
                    const DetectionLevels& levels, const WindowLimits& limits, std::uint8_t number,
                    std::vector<Closed>& others) {
    const int lanes = static_cast<int>(hn::Lanes(D8()));
    const Levels of_row(levels);
    RowState state;
    V8 oldest = hn::Zero(D8());
    int x = 0;
    for (; x + lanes <= width; x += lanes) {
        if (x % kPadding == 0) prefetch_below(rows, x, width, planes);
        state.saturated_samples +=
            advance_block(rows, x, x, planes, of_row, limits, number, others, oldest);
    }
    if (x < width) {
        // The row's end, in a copy that is as long as a register; behind it all is dark.
        alignas(kPadding) std::uint8_t rest[kBatch][kPadding] = {};
        std::array<const std::uint8_t*, kBatch> rests;
        for (int k = 0; k < kBatch; ++k) {
            std::copy(rows[k] + x, rows[k] + width, rest[k]);
            rests[static_cast<std::size_t>(k)] = rest[k];
        }
        state.saturated_samples +=
            advance_block(rests.data(), 0, x, planes, of_row, limits, number, others, oldest);
    }
    alignas(kPadding) std::uint8_t ages[kPadding];
    hn::Store(oldest, D8(), ages);
    for (int i = 0; i < lanes; ++i) state.oldest = std::max(state.oldest, int{ages[i]});
    return state;
}

/// DetectionLevels::first where the samples differ by no more than noise makes them; the others one
/// by one.
void SetBackgrounds(const std::uint8_t* const* rows, int width, const RowPlanes& planes,
                    const DetectionLevels& levels) {
    const D8 d;
    const D16 d16;
    const int lanes = static_cast<int>(hn::Lanes(d));
    const Levels of_row(levels);
    int x = 0;
    for (; x + lanes <= width; x += lanes) {
        V8 least = hn::LoadU(d, rows[0] + x), greatest = least, second = hn::Set(d, 255);
        V16 all = hn::BitCast(d16, least), odd = hn::ShiftRight<8>(all);
        for (int k = 1; k < kBatch; ++k) {
            const V8 sample = hn::LoadU(d, rows[k] + x);
            second = hn::Min(second, hn::Max(least, sample));
            least = hn::Min(least, sample);
            greatest = hn::Max(greatest, sample);
            all = hn::Add(all, hn::BitCast(d16, sample));
            odd = hn::Add(odd, hn::ShiftRight<8>(hn::BitCast(d16, sample)));
        }
        const V8 zero = hn::Zero(d);
        const Halves margin = of_row.margins(halves_of(second, zero));
        const Halves range = halves_of(hn::Sub(greatest, second), zero);
        const auto restless = [](V16 by, V16 most) {
            return hn::SaturatedSub(by, hn::SaturatedAdd(most, hn::ShiftRight<1>(most)));
        };
        const Halves mean = {hn::ShiftLeft<5>(hn::Sub(all, hn::ShiftLeft<8>(odd))),
                             hn::ShiftLeft<5>(odd)};
        hn::Store(high_bytes(mean), d, planes.background_high + x);
        hn::Store(low_bytes(mean), d, planes.background_low + x);
        const V16 moved =
            hn::Or(restless(range.even, margin.even), restless(range.odd, margin.odd));
        if (!hn::AllTrue(d16, hn::Eq(moved, hn::Zero(d16))))
            set_backgrounds_plainly(rows, kBatch, x, x + lanes, planes, levels);
    }
    set_backgrounds_plainly(rows, kBatch, x, width, planes, levels);
}

#endif

}  // namespace stria::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
