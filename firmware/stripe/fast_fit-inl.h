// Fit of the fast kernels, for one instruction set; included once for each by fast_kernels.cpp.
#if defined(STRIA_FAST_FIT_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef STRIA_FAST_FIT_INL
#undef STRIA_FAST_FIT_INL
#else
#define STRIA_FAST_FIT_INL
#endif

#include <hwy/highway.h>

#include <algorithm>

#include "firmware/stripe/fast_kernels.h"
#include "firmware/stripe/gaussian_fit.h"

HWY_BEFORE_NAMESPACE();
namespace stria::fast::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::CappedTag<float, kLanes>;
using DI = hn::RebindToSigned<DF>;
using VF = hn::Vec<DF>;
using MF = hn::Mask<DF>;

constexpr int kMaxIterations = 16;
constexpr int kFullSteps = 4;     // then half ones: what hops to and fro settles
constexpr float kReach = 20.25f;  // squared widths from the middle beyond which a pulse is dark
// Greatest decrease of the deviance by the last step: 0.07 of a sigma for strong pulses, whose
// next step would be far smaller, else 0.03.
constexpr float kStrongDecrease = 5e-3f, kDecrease = 1e-3f;
constexpr float kStrong = 10.0f;  // height over `least`, which is two standard deviations

HWY_INLINE VF constant(float value) { return hn::Set(DF(), value); }

/// 1 / v to 2e-4, which is enough for a weight: Newton's method from a guess by the exponent.
HWY_INLINE VF rough_reciprocal(VF v) {
    const VF two = constant(2.0f);
    VF x = hn::BitCast(DF(), hn::Sub(hn::Set(DI(), 0x7ef311c3), hn::BitCast(DI(), v)));
    x = hn::Mul(x, hn::Sub(two, hn::Mul(v, x)));
    return hn::Mul(x, hn::Sub(two, hn::Mul(v, x)));
}

/// exp(-u / 2) for 0 <= u <= kReach, to 6e-6: a polynomial of fourth degree for 2^x, |x| <= 1/2.
HWY_INLINE VF bell(VF u) {
    const VF t = hn::Mul(u, constant(-0.72134752f));  // log2(e) / 2
    const auto whole = hn::NearestInt(t);
    const VF x = hn::Sub(t, hn::ConvertTo(DF(), whole));
    VF p = hn::Add(hn::Mul(x, constant(0.00961813f)), constant(0.05592079f));
    p = hn::Add(hn::Mul(x, p), constant(0.24022651f));
    p = hn::Add(hn::Mul(x, p), constant(0.69312114f));
    p = hn::Add(hn::Mul(x, p), constant(1.0f));
    return hn::BitCast(DF(), hn::Add(hn::BitCast(DI(), p), hn::ShiftLeft<23>(whole)));
}

/// The model of kLanes pixels' pulses. Its width is that of the exposed pulse, w^2 + h^2 / 3.
class Model {
  public:
    HWY_INLINE Model() {}  // not implied: an implied one is compiled for no instruction set
    HWY_INLINE Model(VF its_height, VF its_position, VF its_width, VF its_level)
        : height(its_height), position(its_position), width(its_width), level(its_level) {}
    VF height, position, width, level;
};

/// Weighted sums over a window of products of the model's slopes by (log height, log width, level,
/// position / width), which are (f, f u, 1, f z), f the pulse, z = (x - position) / width, u = z^2;
/// and of them with the residual.
class Normal {
  public:
    HWY_INLINE Normal()
        : ff(constant(0)),
          ffu(ff),
          f(ff),
          ffz(ff),
          ffuu(ff),
          fu(ff),
          ffuz(ff),
          one(ff),
          fz(ff),
          rf(ff),
          rfu(ff),
          r(ff),
          rfz(ff),
          chi_square(ff),
          squares(ff),
          ffzz(ff) {}
    VF ff, ffu, f, ffz;  // row of f
    VF ffuu, fu, ffuz;   // row of f u: the diagonal, with 1, with f z
    VF one, fz;          // row of 1
    VF rf, rfu, r, rfz;  // with the residual
    VF chi_square, squares;
    VF ffzz;  // f z with itself: the same as ffu, until the width is held
};

class WindowFit {
  public:
    HWY_INLINE WindowFit(const FitTask& task, int lane)
        : task_(task), lane_(lane), min_width_(task.min_width) {
        const DF d;
        const hn::Rebind<std::uint8_t, DF> d8;
        for (int i = 0; i < task.length; ++i)
            hn::Store(
                hn::ConvertTo(d, hn::PromoteTo(DI(), hn::LoadU(d8, task.y + i * kLanes + lane))), d,
                y_ + i * stride());
    }

    HWY_INLINE void run(FitTask& out) {
        const DF d;
        start(out);
        // Found so far; lanes that have converged stay as they are.
        MF open = hn::Eq(constant(0.0f), constant(0.0f));
        Model found = model_;
        const VF strong = hn::Mul(hn::LoadU(d, out.least + lane_), constant(kStrong));
        const VF enough = hn::IfThenElse(hn::Gt(hn::LoadU(d, out.peak + lane_), strong),
                                         constant(kStrongDecrease), constant(kDecrease));
        VF chi_square = constant(0), squares = chi_square, sigma = chi_square, spread = chi_square;
        for (int i = 0; i < kMaxIterations && !hn::AllFalse(d, open); ++i) {
            const Normal sums = accumulate();
            VF decrease, sigma_now, spread_now;
            const Model next =
                step(sums, i < kFullSteps ? 1.0f : 0.5f, decrease, sigma_now, spread_now);
            found = select(open, next, found);
            chi_square = hn::IfThenElse(open, hn::Sub(sums.chi_square, decrease), chi_square);
            squares = hn::IfThenElse(open, sums.squares, squares);
            sigma = hn::IfThenElse(open, sigma_now, sigma);
            spread = hn::IfThenElse(open, spread_now, spread);
            const MF good = hn::And(hn::Ge(decrease, constant(0.0f)), hn::Le(decrease, enough));
            open = hn::AndNot(good, open);
            model_ = found;
        }
        report(found, open, chi_square, squares, sigma, spread, out);
    }

  private:
    static HWY_INLINE int stride() { return static_cast<int>(hn::Lanes(DF())); }
    HWY_INLINE VF sample(int i) const { return hn::Load(DF(), y_ + i * stride()); }
    HWY_INLINE VF time(int i) const { return constant(task_.x[i]); }

    /// From the samples above the tracked background: their greatest, the place of those above a
    /// quarter of it, and their sum.
    HWY_INLINE void start(FitTask& out) {
        const DF d;
        const VF background = hn::LoadU(d, out.background + lane_);
        const VF least = hn::LoadU(d, out.least + lane_);
        VF sum = constant(0), squares = sum, peak = sum, pair = sum;
        VF last = constant(-1e9f);
        for (int i = 0; i < task_.length; ++i) {
            const VF a = hn::Sub(sample(i), background);
            const VF counted = hn::IfThenElseZero(hn::Ge(a, least), a);
            sum = hn::Add(sum, counted);
            squares = hn::Add(squares, hn::Mul(counted, counted));
            peak = hn::Max(peak, counted);
            pair = hn::Max(pair, hn::Add(last, a));
            last = a;
        }
        const VF quarter = hn::Mul(peak, constant(0.25f));
        VF weight = constant(1e-20f), moment = constant(0);
        for (int i = 0; i < task_.length; ++i) {
            const VF a = hn::Max(hn::Sub(hn::Sub(sample(i), background), quarter), constant(0));
            weight = hn::Add(weight, a);
            moment = hn::Add(moment, hn::Mul(a, time(i)));
        }
        hn::StoreU(hn::Div(hn::Mul(sum, sum), squares), d, out.effective + lane_);
        hn::StoreU(peak, d, out.peak + lane_);
        hn::StoreU(pair, d, out.pair + lane_);
        const VF width = hn::Div(hn::Mul(sum, constant(0.4f)), hn::Max(peak, constant(1e-3f)));
        model_ = Model(hn::Max(peak, constant(0.1f)), hn::Div(moment, weight),
                       hn::Min(hn::Max(width, constant(std::max(min_width_, 0.5f))),
                               constant(task_.max_width)),
                       background);
    }

    HWY_INLINE Normal accumulate() const {
        const DF d;
        const VF zero = constant(0);
        const VF inverse = hn::Div(constant(1.0f), model_.width);
        // Fourth cumulant of the aperture, -2 h^4 / 15, over 24 widths^4: times He4(z).
        const VF q = hn::Mul(inverse, inverse);
        const float h2 = task_.half_aperture * task_.half_aperture;
        const VF c4 = hn::Mul(constant(-h2 * h2 / 180.0f), hn::Mul(q, q));
        const VF c6 = hn::Mul(c4, constant(6.0f));
        const VF c3 = hn::Add(constant(1.0f), hn::Mul(c4, constant(3.0f)));
        const VF dark = hn::Sub(model_.level, constant(task_.black));
        const VF floor = constant(task_.variance_floor), gain = constant(task_.variance_gain);
        const VF dark_weight =
            rough_reciprocal(hn::Add(floor, hn::Mul(gain, hn::Max(hn::Add(dark, zero), zero))));
        Normal s;
        for (int i = 0; i < task_.length; ++i) {
            const VF z = hn::Mul(hn::Sub(time(i), model_.position), inverse);
            const VF u = hn::Mul(z, z);
            const MF near = hn::Lt(u, constant(kReach));
            VF r = hn::Sub(sample(i), model_.level);
            VF w = dark_weight;
            if (!hn::AllFalse(d, near)) {
                const VF g = bell(hn::Min(u, constant(kReach)));
                const VF shape = hn::Add(hn::Mul(u, hn::Sub(hn::Mul(c4, u), c6)), c3);
                const VF f = hn::IfThenElseZero(near, hn::Mul(hn::Mul(model_.height, g), shape));
                r = hn::Sub(r, f);
                w = rough_reciprocal(
                    hn::Add(floor, hn::Mul(gain, hn::Max(hn::Add(dark, f), zero))));
                add_pulse(hn::Mul(w, f), f, z, u, r, s);
            }
            const VF wr = hn::Mul(w, r);
            s.one = hn::Add(s.one, w);
            s.r = hn::Add(s.r, wr);
            s.chi_square = hn::Add(s.chi_square, hn::Mul(wr, r));
            s.squares = hn::Add(s.squares, hn::Mul(r, r));
        }
        s.ffzz = s.ffu;
        return s;
    }

    /// Takes the width out of the equations where it would go below the least.
    HWY_INLINE Normal hold_width_at_limit(Normal s) const {
        const MF held =
            hn::And(hn::Le(model_.width, constant(min_width_)), hn::Lt(s.rfu, constant(0.0f)));
        s.ffu = hn::IfThenZeroElse(held, s.ffu);
        s.ffuu = hn::IfThenElse(held, constant(1.0f), s.ffuu);
        s.fu = hn::IfThenZeroElse(held, s.fu);
        s.ffuz = hn::IfThenZeroElse(held, s.ffuz);
        s.rfu = hn::IfThenZeroElse(held, s.rfu);
        return s;
    }

    static HWY_INLINE void add_pulse(VF wf, VF f, VF z, VF u, VF r, Normal& s) {
        const VF wff = hn::Mul(wf, f), wfr = hn::Mul(wf, r);
        const VF wffu = hn::Mul(wff, u);
        s.ff = hn::Add(s.ff, wff);
        s.ffu = hn::Add(s.ffu, wffu);
        s.f = hn::Add(s.f, wf);
        s.ffz = hn::Add(s.ffz, hn::Mul(wff, z));
        s.ffuu = hn::Add(s.ffuu, hn::Mul(wffu, u));
        s.fu = hn::Add(s.fu, hn::Mul(wf, u));
        s.ffuz = hn::Add(s.ffuz, hn::Mul(wffu, z));
        s.fz = hn::Add(s.fz, hn::Mul(wf, z));
        s.rf = hn::Add(s.rf, wfr);
        s.rfu = hn::Add(s.rfu, hn::Mul(wfr, u));
        s.rfz = hn::Add(s.rfz, hn::Mul(wfr, z));
    }

    /// Solves the normal equations by elimination in the order of Normal. `sigma` is the position's
    /// standard deviation, `spread` the height's; `share` of the step is made.
    HWY_INLINE Model step(const Normal& sums, float share, VF& decrease, VF& sigma,
                          VF& spread) const {
        const VF one = constant(1.0f);
        const Normal s = hold_width_at_limit(sums);
        const VF i0 = hn::Div(one, s.ff);
        const VF l1 = hn::Mul(s.ffu, i0), l2 = hn::Mul(s.f, i0), l3 = hn::Mul(s.ffz, i0);
        const VF a11 = hn::Sub(s.ffuu, hn::Mul(l1, s.ffu));
        const VF a12 = hn::Sub(s.fu, hn::Mul(l1, s.f));
        const VF a13 = hn::Sub(s.ffuz, hn::Mul(l1, s.ffz));
        VF a22 = hn::Sub(s.one, hn::Mul(l2, s.f));
        VF a23 = hn::Sub(s.fz, hn::Mul(l2, s.ffz));
        VF a33 = hn::Sub(s.ffzz, hn::Mul(l3, s.ffz));
        const VF g1 = hn::Sub(s.rfu, hn::Mul(l1, s.rf));
        VF g2 = hn::Sub(s.r, hn::Mul(l2, s.rf)), g3 = hn::Sub(s.rfz, hn::Mul(l3, s.rf));
        const VF i1 = hn::Div(one, a11);
        const VF m2 = hn::Mul(a12, i1), m3 = hn::Mul(a13, i1);
        a22 = hn::Sub(a22, hn::Mul(m2, a12));
        a23 = hn::Sub(a23, hn::Mul(m2, a13));
        a33 = hn::Sub(a33, hn::Mul(m3, a13));
        g2 = hn::Sub(g2, hn::Mul(m2, g1));
        g3 = hn::Sub(g3, hn::Mul(m3, g1));
        const VF i2 = hn::Div(one, a22);
        const VF n3 = hn::Mul(a23, i2);
        a33 = hn::Sub(a33, hn::Mul(n3, a23));
        g3 = hn::Sub(g3, hn::Mul(n3, g2));
        const VF i3 = hn::Div(one, a33);

        const VF d3 = hn::Mul(g3, i3);
        const VF d2 = hn::Mul(hn::Sub(g2, hn::Mul(a23, d3)), i2);
        const VF d1 = hn::Mul(hn::Sub(hn::Sub(g1, hn::Mul(a12, d2)), hn::Mul(a13, d3)), i1);
        const VF d0 = hn::Sub(hn::Sub(hn::Sub(hn::Mul(s.rf, i0), hn::Mul(l1, d1)), hn::Mul(l2, d2)),
                              hn::Mul(l3, d3));
        decrease = hn::Add(hn::Add(hn::Mul(d0, s.rf), hn::Mul(d1, s.rfu)),
                           hn::Add(hn::Mul(d2, s.r), hn::Mul(d3, s.rfz)));
        sigma = hn::Mul(model_.width, hn::Sqrt(i3));
        // Diagonal element of the inverse for the height: (L D L')^-1 of the first unit vector.
        const VF y2 = hn::Sub(hn::Mul(m2, l1), l2);
        const VF y3 = hn::Sub(hn::Sub(hn::Mul(m3, l1), l3), hn::Mul(n3, y2));
        const VF variance =
            hn::Add(hn::Add(i0, hn::Mul(hn::Mul(l1, l1), i1)),
                    hn::Add(hn::Mul(hn::Mul(y2, y2), i2), hn::Mul(hn::Mul(y3, y3), i3)));
        spread = hn::Mul(model_.height, hn::Sqrt(variance));

        const VF way = constant(share);
        Model next;
        next.height =
            hn::Mul(model_.height,
                    hn::Add(one, hn::Clamp(hn::Mul(d0, way), constant(-0.6f), constant(1.5f))));
        const VF grow = hn::Clamp(hn::Mul(d1, way), constant(-0.5f), constant(0.5f));
        const VF factor = hn::Add(one, hn::Mul(grow, hn::Add(one, hn::Mul(grow, constant(0.5f)))));
        next.width = hn::Max(hn::Mul(model_.width, factor), constant(min_width_));
        next.level = hn::Add(model_.level, hn::Mul(d2, way));
        const VF move = hn::Clamp(hn::Mul(d3, way), constant(-1.0f), constant(1.0f));
        next.position = hn::Add(model_.position, hn::Mul(model_.width, move));
        return next;
    }

    static HWY_INLINE Model select(MF which, const Model& a, const Model& b) {
        return {hn::IfThenElse(which, a.height, b.height),
                hn::IfThenElse(which, a.position, b.position),
                hn::IfThenElse(which, a.width, b.width), hn::IfThenElse(which, a.level, b.level)};
    }

    HWY_INLINE void report(const Model& found, MF open, VF chi_square, VF squares, VF sigma,
                           VF spread, FitTask& out) const {
        const DF d;
        const float blur = task_.half_aperture * task_.half_aperture / 3.0f;
        const VF square = hn::Sub(hn::Mul(found.width, found.width), constant(blur));
        const MF sound = hn::Ge(square, constant(0.01f));  // false for what is no number
        const VF width = hn::Sqrt(hn::Max(square, constant(0.01f)));
        hn::StoreU(found.position, d, out.position + lane_);
        hn::StoreU(sigma, d, out.sigma + lane_);
        hn::StoreU(width, d, out.width + lane_);
        hn::StoreU(found.height, d, out.height + lane_);
        hn::StoreU(hn::Div(hn::Mul(found.height, found.width), width), d, out.amplitude + lane_);
        hn::StoreU(spread, d, out.height_sigma + lane_);
        hn::StoreU(found.level, d, out.level + lane_);
        hn::StoreU(chi_square, d, out.chi_square + lane_);
        hn::StoreU(squares, d, out.squares + lane_);
        const auto good = hn::RebindMask(DI(), hn::AndNot(open, sound));
        hn::StoreU(hn::IfThenElseZero(good, hn::Set(DI(), 1)), DI(), out.converged + lane_);
    }

    const FitTask& task_;
    const int lane_;
    const float min_width_;  ///< of the exposed pulse
    Model model_;
    HWY_ALIGN float y_[kMaxFitSamples * kLanes];
};

void FitWindows(FitTask& task) {
    for (int lane = 0; lane < kLanes; lane += static_cast<int>(hn::Lanes(DF())))
        WindowFit(task, lane).run(task);
}

}  // namespace stria::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
