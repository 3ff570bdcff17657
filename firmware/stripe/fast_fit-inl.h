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
constexpr float kSettled = 1e-4f;
constexpr float kDoubtfulSettled = 4e-5f;  // more noise than is stated, or few samples
// Change of a pulse one frame wide, relatively, that leaves its sigma as it was to a few per cent.
constexpr float kMatrixServes = 0.03f;
// Squared half aperture over width up to which the fourth cumulant changes no sample by more than
// 3e-5 of the height.
constexpr float kBlurred = 1.0f / 24.0f;

/// The fits of as many of a group's lanes as a register holds. Not inlined where that would copy
/// the loops: two of them take turns.
class LaneFit {
  public:
    HWY_INLINE LaneFit(FitTask& task, int lane)
        : task_(task),
          length_(task.windows->past - task.windows->first),
          inner_begin_(task.windows->inner_first - task.windows->first),
          inner_end_(task.windows->inner_past - task.windows->first),
          min_width_(std::sqrt(static_cast<float>(kMinPulseWidth * kMinPulseWidth) * task.period *
                                   task.period +
                               task.half_aperture * task.half_aperture / 3.0f)),
          lanes_(task, lane),
          found_(lanes_),
          changed_(constant(0.0f)),
          energy_(constant(0.0f)),
          weight_(constant(1.0f)),
          open_(lanes_.held) {}

    /// From the samples that stand out of the tracked background's noise: moments weighted by their
    /// squares, which for a Gaussian are as good as the fit, to first order.
    HWY_NOINLINE void start(bool shot) {
        Moments m;
        int i = 0;
        for (; i < inner_begin_; ++i) take<true>(i, m);
        for (; i < inner_end_; ++i) take<false>(i, m);
        for (; i < length_; ++i) take<true>(i, m);
        lanes_.note(m.peak, m.pair);
        lanes_.count_effective(hn::Div(hn::Mul(m.sum, m.sum), m.squares), task_);
        open_ = lanes_.asked;  // the others stay as they are
        if (!shot) weight_ = hn::Div(constant(1.0f), lanes_.variance);
        const VF one = hn::Div(constant(1.0f), m.s0);
        const VF middle = hn::Mul(m.s1, one);
        const VF square = hn::Sub(hn::Mul(m.s2, one), hn::Mul(middle, middle));
        const VF width = hn::Clamp(hn::Sqrt(hn::Max(hn::Add(square, square), constant(0.01f))),
                                   constant(std::max(min_width_, 0.5f * task_.period)),
                                   constant(task_.max_width));
        const VF height =  // the integral of the square is height^2 width sqrt(pi)
            hn::Sqrt(hn::Div(m.s0, hn::Mul(width, constant(1.7724539f))));
        model_ = Model(hn::Max(height, constant(0.1f)), middle, width, lanes_.background);
    }

    /// A step of Fisher scoring; true while there are lanes that want another one. Without shot
    /// noise one variance stands for all of a window's samples, and a matrix serves three steps.
    template <bool kShot>
    HWY_NOINLINE bool improve(int i) {
        const DF d;
        const VF none = constant(0.0f);
        if (hn::AllFalse(d, open_)) return false;
        const bool renew = kShot || i % 3 == 0;
        Sums s;
        if (renew) {
            s = accumulate<kShot, true>();
            factor_ =
                Factor(s, hn::And(hn::Le(model_.width, constant(min_width_)), hn::Lt(s.rfu, none)));
            changed_ = none;
            energy_ = energy(model_);
        } else {
            s = accumulate<kShot, false>();
        }
        if (!kShot) s.squares = s.rr;
        const Step step = factor_.solve(s);
        const VF decrease = hn::Mul(step.decrease, weight_);
        const VF variance = kShot ? constant(1.0f) : lanes_.variance;
        const VF place = hn::Mul(factor_.place_variance(), variance);
        changed_ = hn::Add(changed_, hn::Max(hn::Max(hn::Abs(step.height), hn::Abs(step.width)),
                                             hn::Abs(step.place)));
        const Model next = moved(step, i < kFullSteps ? 1.0f : 0.5f);
        found_.note(open_, next, hn::Sub(hn::Mul(s.rr, weight_), decrease), s.squares, place,
                    hn::Mul(factor_.height_variance(), variance), kShot ? energy(next) : energy_);
        if (kShot || !renew) found_.note_residual(open_, s.greatest);
        const VF rest =
            hn::Mul(decrease, hn::Add(hn::Mul(constant(8.0f), place), hn::Mul(changed_, changed_)));
        const VF settled = hn::IfThenElse(found_.is_doubtful(task_), constant(kDoubtfulSettled),
                                          constant(kSettled));
        MF good = hn::And(hn::Ge(decrease, none), hn::Le(rest, settled));
        if (kShot) good = hn::And(good, hn::Lt(changed_, constant(0.01f)));
        if (!kShot && i == 0) good = hn::And(good, found_.is_inconspicuous());
        if (!kShot) good = hn::And(good, hn::Le(changed_, matrix_serves()));
        model_ = found_.model;
        open_ = hn::AndNot(good, open_);
        return true;
    }

    HWY_NOINLINE void report() { found_.report(task_, open_); }

  private:
    static HWY_INLINE int stride() { return static_cast<int>(hn::Lanes(DF())); }
    HWY_INLINE VF sample(int i) const { return hn::Load(DF(), y_ + i * stride()); }
    HWY_INLINE VF time(int i) const { return constant(task_.x[i]); }
    /// Lanes whose window holds sample i.
    HWY_INLINE MF held_by(int i) const {
        const VI at = hn::Set(DI(), i);
        return hn::RebindMask(DF(), hn::AndNot(hn::Lt(at, lanes_.begin), hn::Lt(at, lanes_.end)));
    }
    /// Relative change of the model up to which the matrix says its sigma, too: of few samples a
    /// width, where each of them lies matters, and most so beside a wide gap.
    HWY_INLINE VF matrix_serves() const {
        const VF samples = hn::Mul(model_.width, constant(1.0f / task_.widest_gap));
        return hn::Mul(constant(kMatrixServes), hn::Mul(samples, hn::Mul(samples, samples)));
    }
    /// What the variances fall with.
    static HWY_INLINE VF energy(const Model& model) {
        return hn::Mul(hn::Mul(model.height, model.height), model.width);
    }

    /// Sums of samples above the tracked background; s: of their squares over time.
    class Moments {
      public:
        HWY_INLINE Moments()
            : sum(constant(0.0f)),
              squares(sum),
              peak(sum),
              pair(sum),
              last(constant(-1e9f)),
              s0(constant(1e-20f)),
              s1(sum),
              s2(sum) {}
        VF sum, squares, peak, pair, last;
        VF s0, s1, s2;
    };

    /// Loads sample i for all passes.
    template <bool kMasked>
    HWY_INLINE void take(int i, Moments& m) {
        const DF d;
        const hn::Rebind<std::uint8_t, DF> d8;
        const VI bytes =
            hn::PromoteTo(DI(), hn::LoadU(d8, task_.samples[i] + task_.offset + lanes_.lane));
        const VF y = hn::ConvertTo(d, bytes);
        hn::Store(y, d, y_ + i * stride());
        VF a = hn::Sub(y, lanes_.background);
        if (kMasked) a = hn::IfThenElse(held_by(i), a, constant(-1e9f));
        const VF counted = hn::IfThenElseZero(hn::Ge(a, lanes_.least), a);
        const VF square = hn::Mul(counted, counted);
        m.sum = hn::Add(m.sum, counted);
        m.squares = hn::Add(m.squares, square);
        m.peak = hn::Max(m.peak, counted);
        m.pair = hn::Max(m.pair, hn::Add(m.last, a));
        m.last = a;
        const VF part = hn::Mul(square, constant(task_.interval[i]));
        const VF moment = hn::Mul(part, time(i));
        m.s0 = hn::Add(m.s0, part);
        m.s1 = hn::Add(m.s1, moment);
        m.s2 = hn::Add(m.s2, hn::Mul(moment, time(i)));
    }

    /// What a pass over the samples needs of the model.
    class Pass {
      public:
        HWY_INLINE Pass() {}  // not implied: see Model
        VF inverse, c4, c6, c3, dark;
        bool blurred;  ///< some c4 is not 0
    };

    template <bool kShot, bool kMatrix>
    HWY_INLINE Sums accumulate() const {
        Pass p;
        p.inverse = hn::Div(constant(1.0f), model_.width);
        // Fourth cumulant of the aperture, -2 h^4 / 15, over 24 widths^4: times He4(z).
        const float h2 = task_.half_aperture * task_.half_aperture;
        const VF blur = hn::Mul(constant(h2), hn::Mul(p.inverse, p.inverse));
        const MF matters = hn::Gt(blur, constant(kBlurred));
        p.c4 = hn::IfThenElseZero(matters, hn::Mul(model_.height, hn::Mul(constant(-1.0f / 180.0f),
                                                                          hn::Mul(blur, blur))));
        p.blurred = !hn::AllFalse(DF(), matters);
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
                VF shape = p.c3;
                if (p.blurred) shape = hn::Add(hn::Mul(u, hn::Sub(hn::Mul(p.c4, u), p.c6)), shape);
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

    FitTask& task_;
    const int length_, inner_begin_, inner_end_;
    const float min_width_;  ///< of the exposed pulse
    LaneWindows lanes_;
    Found found_;
    Model model_;
    Factor factor_;
    VF changed_;  ///< relatively, since the matrix was made
    VF energy_;   ///< when it was made
    VF weight_;   ///< of squared residuals, where it is the same for all of a window
    MF open_;     ///< lanes that want another step
    HWY_ALIGN float y_[kMaxFitSamples * kLanes];
};

template <bool kShot>
HWY_INLINE void fit_in_turns(LaneFit* one, LaneFit* other) {
    one->start(kShot);
    if (other != nullptr) other->start(kShot);
    bool more = true;
    for (int i = 0; i < kMaxIterations && more; ++i) {
        more = one->improve<kShot>(i);
        if (other != nullptr && other->improve<kShot>(i)) more = true;
    }
    one->report();
    if (other != nullptr) other->report();
}

/// Two groups take turns: while one waits for a solution, the other sums.
void FitGroups(FitTask& task, FitTask* other) {
    task.lanes = task.pulses = task.unsure = 0;
    if (other != nullptr) other->lanes = other->pulses = other->unsure = 0;
    const bool shot = has_shot_noise(task);
    for (int lane = 0; lane < kLanes; lane += static_cast<int>(hn::Lanes(DF()))) {
        LaneFit first(task, lane);
        if (other == nullptr) {
            shot ? fit_in_turns<true>(&first, nullptr) : fit_in_turns<false>(&first, nullptr);
            continue;
        }
        LaneFit second(*other, lane);
        shot ? fit_in_turns<true>(&first, &second) : fit_in_turns<false>(&first, &second);
    }
}

}  // namespace stria::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
