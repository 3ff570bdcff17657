#include "firmware/stripe/fast_kernels.h"

#include <algorithm>
#include <stdexcept>
#include <string>

// Vectors whose length is unknown to the compiler cannot be members of a struct.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "firmware/stripe/fast_kernels.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, which includes this file once more for each instruction set.
#include "firmware/stripe/fast_collect-inl.h"
#include "firmware/stripe/fast_detect-inl.h"
#include "firmware/stripe/fast_fit-inl.h"

#if HWY_ONCE

namespace stria::fast {

HWY_EXPORT(AdvanceRow);
HWY_EXPORT(SetBackgrounds);
HWY_EXPORT(CollectGroups);
HWY_EXPORT(FitGroups);

int margin_frames(int last, const WindowLimits& limits) {
    return std::min(last / 2 + 4, limits.history_frames);
}

RowState advance_row(const std::uint8_t* const* rows, int width, const RowPlanes& planes,
                     const DetectionLevels& levels, const WindowLimits& limits, std::uint8_t number,
                     std::vector<Closed>& others) {
    return HWY_DYNAMIC_DISPATCH(AdvanceRow)(rows, width, planes, levels, limits, number, others);
}

void set_backgrounds(const std::uint8_t* const* rows, int width, const RowPlanes& planes,
                     const DetectionLevels& levels) {
    HWY_DYNAMIC_DISPATCH(SetBackgrounds)(rows, width, planes, levels);
}

int collect_groups(const RowPlanes& planes, int width, int now, int patience,
                   const WindowLimits& limits, std::vector<GroupWindows>& groups) {
    return HWY_DYNAMIC_DISPATCH(CollectGroups)(planes, width, now, patience, limits, groups);
}

void fit_groups(FitTask& task, FitTask* other) { HWY_DYNAMIC_DISPATCH(FitGroups)(task, other); }

std::vector<const char*> instruction_sets() {
    std::vector<const char*> names;
    const std::int64_t here = hwy::SupportedTargets() & HWY_TARGETS;
    for (std::int64_t rest = here; rest != 0; rest &= rest - 1)
        names.push_back(hwy::TargetName(rest & -rest));
    return names;
}

void use_instruction_set(const char* name) {
    hwy::SetSupportedTargetsForTest(0);
    if (std::string(name).empty()) return;
    for (std::int64_t rest = hwy::SupportedTargets() & HWY_TARGETS; rest != 0; rest &= rest - 1) {
        const std::int64_t target = rest & -rest;
        if (std::string(hwy::TargetName(target)) != name) continue;
        hwy::SetSupportedTargetsForTest(target);
        return;
    }
    throw std::invalid_argument(std::string("use_instruction_set: ") + name +
                                " cannot run on this processor");
}

}  // namespace stria::fast

#endif
