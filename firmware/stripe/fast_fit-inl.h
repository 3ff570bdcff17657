// Fit of the fast kernels, for one instruction set; included once for each by fast_kernels.cpp.
#if defined(STRIA_FAST_FIT_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef STRIA_FAST_FIT_INL
#undef STRIA_FAST_FIT_INL
#else
#define STRIA_FAST_FIT_INL
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "firmware/stripe/fast_judge-inl.h"
#include "firmware/stripe/fast_kernels.h"
#include "firmware/stripe/fast_sums-inl.h"
#include "firmware/stripe/gaussian_fit.h"
#include "firmware/stripe/pixel_window.h"

HWY_BEFORE_NAMESPACE();
namespace stria::fast::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kMaxIterations = 9;  // what takes longer is not sure of its solution
constexpr int kFullSteps = 6;      // then half ones: what hops to and fro settles
// A step's remainder, in sigmas, is about twice its length times the relative change since the
// matrix was made, or the relative noise: its square, over 4, that is small enough.
constexpr float kSettled = 4e-4f;

class GroupFit {
  public:
    HWY_INLINE GroupFit(const FitTask& task, int lane)
        : task_(task),
          lane_(lane),
          length_(task.windows->past - task.windows->first),
          inner_begin_(task.windows->inner_first - task.windows->first),
          inner_end_(task.windows->inner_past - task.windows->first),
          min_width_(std::sqrt(static_cast<float>(kMinPulseWidth * kMinPulseWidth) * task.period *
                                   task.period +
                               task.half_aperture * task.half_aperture / 3.0f)),
          lanes_(task, lane) {
        const DF d;
        const hn::Rebind<std::uint8_t, DF> d8;
        const std::size_t offset = task.offset + static_cast<std::size_t>(lane);
        for (int i = 0; i < length_; ++i)
            hn::Store(
                hn::ConvertTo(d, hn::PromoteTo(DI(), hn::LoadU(d8, task.samples[i] + offset))), d,
                y_ + i * stride());
    }

    HWY_INLINE void run(FitTask& out) {
        start(out);
        // One variance for all of a window's samples where it changes by less than a thousandth.
        if (255.0f * task_.variance_gain < 1e-3f * task_.variance_floor)
            improve<false>(out);
        else
            improve<true>(out);
    }

  private:
    static HWY_INLINE int stride() { return static_cast<int>(hn::Lanes(DF())); }
    HWY_INLINE VF sample(int i) const { return hn::Load(DF(), y_ + i * stride()); }
    HWY_INLINE VF time(int i) const { return constant(task_.x[i]); }
    /// Lanes whose window holds sample i.
    HWY_INLINE MF held_by(int i) const {
        const VI at = hn::Set(DI(), i);
        return hn::RebindMask(DF(), hn::AndNot(hn::Lt(at, lanes_.begin), hn::Lt(at, lanes_.end)));
    }

    /// From the samples that stand out of the tracked background's noise: moments weighted by their
    /// squares, which for a Gaussian are as good as the fit, to first order.
    HWY_INLINE void start(FitTask& out) {
        const VF least = lanes_.least, none = constant(0.0f);
        VF sum = none, squares = none, peak = none, pair = none, last = constant(-1e9f);
        VF s0 = constant(1e-20f), s1 = none, s2 = none;
        for (int i = 0; i < length_; ++i) {
            VF a = hn::Sub(sample(i), lanes_.background);
            if (i < inner_begin_ || i >= inner_end_)
                a = hn::IfThenElse(held_by(i), a, constant(-1e9f));
            const VF counted = hn::IfThenElseZero(hn::Ge(a, least), a);
            const VF square = hn::Mul(counted, counted);
            sum = hn::Add(sum, counted);
            squares = hn::Add(squares, square);
            peak = hn::Max(peak, counted);
            pair = hn::Max(pair, hn::Add(last, a));
            last = a;
            const VF part = hn::Mul(square, constant(task_.interval[i]));
            const VF moment = hn::Mul(part, time(i));
            s0 = hn::Add(s0, part);
            s1 = hn::Add(s1, moment);
            s2 = hn::Add(s2, hn::Mul(moment, time(i)));
        }
        lanes_.note(peak, pair);
        lanes_.count_effective(hn::Div(hn::Mul(sum, sum), squares), out);
        const VF middle = hn::Div(s1, s0);
        const VF square = hn::Sub(hn::Div(s2, s0), hn::Mul(middle, middle));
        const VF width = hn::Clamp(hn::Sqrt(hn::Max(hn::Add(square, square), constant(0.01f))),
                                   constant(std::max(min_width_, 0.5f * task_.period)),
                                   constant(task_.max_width));
        const VF height =  // the integral of the square is height^2 width sqrt(pi)
            hn::Sqrt(hn::Div(s0, hn::Mul(width, constant(1.7724539f))));
        model_ = Model(hn::Max(height, constant(0.1f)), middle, width, lanes_.background);
    }

    /// What a pass over the samples needs of the model.
    struct Pass {
        VF inverse, c4, c6, c3, dark;
    };

    template <bool kShot, bool kMatrix>
    HWY_INLINE Sums accumulate() const {
        Pass p;
        p.inverse = hn::Div(constant(1.0f), model_.width);
        // Fourth cumulant of the aperture, -2 h^4 / 15, over 24 widths^4: times He4(z).
        const VF q = hn::Mul(p.inverse, p.inverse);
        const float h2 = task_.half_aperture * task_.half_aperture;
        p.c4 = hn::Mul(model_.height, hn::Mul(constant(-h2 * h2 / 180.0f), hn::Mul(q, q)));
        p.c6 = hn::Mul(p.c4, constant(6.0f));
        p.c3 = hn::Add(model_.height, hn::Mul(p.c4, constant(3.0f)));
        p.dark = hn::Sub(model_.level, constant(task_.black));
        Sums s;
        int i = 0;
        for (; i < inner_begin_; ++i) add<kShot, kMatrix, true>(i, p, s);
        for (; i < inner_end_; ++i) add<kShot, kMatrix, false>(i, p, s);
        for (; i < length_; ++i) add<kShot, kMatrix, true>(i, p, s);
        if (!kShot) s.one = lanes_.count;
        return s;
    }

    template <bool kShot, bool kMatrix, bool kMasked>
    HWY_INLINE void add(int i, const Pass& p, Sums& s) const {
        const DF d;
        const VF floor = constant(task_.variance_floor), gain = constant(task_.variance_gain);
        const VF none = constant(0.0f);
        const VF z = hn::Mul(hn::Sub(time(i), model_.position), p.inverse);
        const VF u = hn::Mul(z, z);
        MF near = hn::Lt(u, constant(kReach));
        if (kMasked) near = hn::And(near, held_by(i));
        VF r = hn::Sub(sample(i), model_.level);
        VF light = p.dark, w = none;
        const bool lit = !hn::AllFalse(d, near);
        if (lit || kShot) {
            VF f = none;
            if (lit) {
                const VF shape = hn::Add(hn::Mul(u, hn::Sub(hn::Mul(p.c4, u), p.c6)), p.c3);
                f = hn::IfThenElseZero(near, hn::Mul(bell(u), shape));
            }
            r = hn::Sub(r, f);
            if (kShot) {
                light = hn::Add(light, f);
                w = rough_reciprocal(hn::Add(floor, hn::Mul(gain, hn::Max(light, none))));
            }
            if (lit) s.add_pulse<kMatrix>(kShot ? hn::Mul(w, f) : f, f, z, u, r);
        }
        if (kMasked) r = hn::IfThenElseZero(held_by(i), r);
        if (kShot || !kMatrix) s.note(r);
        const VF wr = kShot ? hn::Mul(w, r) : r;
        s.r = hn::Add(s.r, wr);
        s.rr = hn::Add(s.rr, hn::Mul(wr, r));
        if (!kShot) return;
        s.squares = hn::Add(s.squares, hn::Mul(r, r));
        s.one = hn::Add(s.one, kMasked ? hn::IfThenElseZero(held_by(i), w) : w);
    }

    /// Fisher scoring. Without shot noise each matrix serves two steps.
    template <bool kShot>
    HWY_INLINE void improve(FitTask& out) {
        const DF d;
        const VF none = constant(0.0f);
        const VF variance = kShot ? constant(1.0f) : lanes_.variance;
        MF open = lanes_.asked;  // the others stay as they are
        Found found(lanes_);
        Factor factor;
        VF changed = none, scale = constant(1.0f);
        for (int i = 0; i < kMaxIterations && !hn::AllFalse(d, open); ++i) {
            const bool renew = kShot || i % 3 == 0;
            Sums s;
            if (renew) {
                s = accumulate<kShot, true>();
                factor = Factor(
                    s, hn::And(hn::Le(model_.width, constant(min_width_)), hn::Lt(s.rfu, none)));
                changed = none;
                scale = hn::Mul(hn::Mul(model_.height, model_.height), model_.width);
            } else {
                s = accumulate<kShot, false>();
            }
            if (!kShot) s.squares = s.rr;
            Step step = factor.solve(s);
            const VF inverse = hn::Div(constant(1.0f), variance);
            const VF decrease = hn::Mul(step.decrease, inverse);
            const VF place = hn::Mul(factor.place_variance(), variance);
            changed = hn::Add(changed, hn::Max(hn::Max(hn::Abs(step.height), hn::Abs(step.width)),
                                               hn::Abs(step.place)));
            const Model next = moved(step, i < kFullSteps ? 1.0f : 0.5f);
            // Both variances fall with the pulse's energy.
            const VF less =
                kShot ? constant(1.0f)
                      : hn::Div(scale, hn::Mul(hn::Mul(next.height, next.height), next.width));
            const VF rest = hn::Mul(
                decrease, hn::Add(hn::Mul(constant(8.0f), place), hn::Mul(changed, changed)));
            found.note(open, next, hn::Sub(hn::Mul(s.rr, inverse), decrease), s.squares,
                       hn::Mul(less, place),
                       hn::Mul(less, hn::Mul(factor.height_variance(), variance)));
            if (kShot || !renew) found.note_residual(open, s.greatest);
            MF good = hn::And(hn::Ge(decrease, none), hn::Le(rest, constant(kSettled)));
            if (kShot) good = hn::And(good, hn::Lt(changed, constant(0.01f)));
            if (!kShot && i == 0) good = hn::And(good, found.is_inconspicuous());
            model_ = found.model;
            open = hn::AndNot(good, open);
        }
        found.report(task_, open, out);
    }

    HWY_INLINE Model moved(const Step& step, float share) const {
        const VF way = constant(share), one = constant(1.0f);
        Model next;
        next.height = hn::Mul(
            model_.height,
            hn::Add(one, hn::Clamp(hn::Mul(step.height, way), constant(-0.6f), constant(1.5f))));
        const VF grow = hn::Clamp(hn::Mul(step.width, way), constant(-0.5f), constant(0.5f));
        const VF factor = hn::Add(one, hn::Mul(grow, hn::Add(one, hn::Mul(grow, constant(0.5f)))));
        next.width = hn::Max(hn::Mul(model_.width, factor), constant(min_width_));
        next.level = hn::Add(model_.level, hn::Mul(step.level, way));
        const VF move = hn::Clamp(hn::Mul(step.place, way), constant(-1.0f), constant(1.0f));
        next.position = hn::Add(model_.position, hn::Mul(model_.width, move));
        return next;
    }

    const FitTask& task_;
    const int lane_;
    const int length_, inner_begin_, inner_end_;
    const float min_width_;  ///< of the exposed pulse
    LaneWindows lanes_;
    Model model_;
    HWY_ALIGN float y_[kMaxFitSamples * kLanes];
};

void FitGroup(FitTask& task) {
    task.lanes = task.pulses = task.unsure = 0;
    for (int lane = 0; lane < kLanes; lane += static_cast<int>(hn::Lanes(DF())))
        GroupFit(task, lane).run(task);
}

}  // namespace stria::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
