// Which windows are fitted together, for one instruction set; included once for each by
// fast_kernels.cpp.
#if defined(STRIA_FAST_COLLECT_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef STRIA_FAST_COLLECT_INL
#undef STRIA_FAST_COLLECT_INL
#else
#define STRIA_FAST_COLLECT_INL
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "firmware/stripe/fast_kernels.h"
#include "firmware/stripe/fast_sums-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stria::fast::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The windows that wait at kLanes pixels from x on.
HWY_INLINE void windows_at(const RowPlanes& planes, int x, int now, const WindowLimits& limits,
                           GroupWindows& out) {
    const DI d;
    const hn::Rebind<std::uint8_t, DI> d8;
    const auto load = [&](const std::uint8_t* plane, int lane)
                          HWY_ATTR { return hn::PromoteTo(d, hn::LoadU(d8, plane + x + lane)); };
    const VI zero = hn::Zero(d), present = hn::Set(d, now);
    VI first = present, inner_past = present, past = zero, inner_first = zero;
    for (int lane = 0; lane < kLanes; lane += static_cast<int>(hn::Lanes(d))) {
        const VI waiting = load(planes.waiting, lane);
        const auto none = hn::Eq(waiting, zero);
        const VI waited =
            hn::And(hn::Sub(present, load(planes.waiting_end, lane)), hn::Set(d, 255));
        const VI margin =
            hn::Min(hn::Add(hn::ShiftRight<1>(hn::Sub(waiting, hn::Set(d, 1))), hn::Set(d, 4)),
                    hn::Set(d, limits.history_frames));
        const VI end = hn::Sub(present, waited);
        const VI begin = hn::Sub(end, hn::Add(waiting, hn::Add(margin, margin)));
        first = hn::Min(first, hn::IfThenElse(none, present, begin));
        inner_first = hn::Max(inner_first, hn::IfThenZeroElse(none, begin));
        past = hn::Max(past, hn::IfThenZeroElse(none, end));
        inner_past = hn::Min(inner_past, hn::IfThenElse(none, present, end));
        hn::StoreU(hn::IfThenZeroElse(none, begin), d, out.begin + lane);
        hn::StoreU(hn::IfThenZeroElse(none, end), d, out.end + lane);
        const VI level = hn::Or(hn::ShiftLeft<8>(load(planes.waiting_high, lane)),
                                load(planes.waiting_low, lane));
        hn::StoreU(hn::Mul(hn::ConvertTo(DF(), level), constant(1.0f / 256.0f)), DF(),
                   out.background + lane);
        hn::StoreU(
            hn::ConvertTo(DF(), hn::Add(load(planes.waiting_threshold, lane), hn::Set(d, 1))), DF(),
            out.level + lane);
    }
    out.x = x;
    out.first = hn::GetLane(hn::MinOfLanes(d, first));
    out.past = hn::GetLane(hn::MaxOfLanes(d, past));
    out.inner_first = hn::GetLane(hn::MaxOfLanes(d, inner_first));
    out.inner_past = std::max(out.inner_first, hn::GetLane(hn::MinOfLanes(d, inner_past)));
}

int CollectGroups(const RowPlanes& planes, int width, int now, int patience,
                  const WindowLimits& limits, std::vector<GroupWindows>& groups) {
    int needed = 0;
    for (int x = 0; x < width; x += kLanes) {
        const std::uint8_t flags = planes.flags[x / kLanes];
        if (HWY_LIKELY((flags & kWaiting) == 0)) continue;
        groups.emplace_back();
        GroupWindows& group = groups.back();
        windows_at(planes, x, now, limits, group);
        if (now - group.inner_past < patience && (flags & kOpen) != 0) {
            needed = std::max(needed, now - group.first);
            groups.pop_back();
            continue;
        }
        std::memset(planes.waiting + x, 0, kLanes);
        planes.lower(x, kWaiting);
        group.found = (flags & kFound) != 0;
        planes.raise(x, kFound);
    }
    return needed;
}

}  // namespace stria::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
