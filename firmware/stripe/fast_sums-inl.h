// The fit's sums over a window and its normal equations, for one instruction set; included once for
// each by fast_kernels.cpp.
#if defined(STRIA_FAST_SUMS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef STRIA_FAST_SUMS_INL
#undef STRIA_FAST_SUMS_INL
#else
#define STRIA_FAST_SUMS_INL
#endif

#include <hwy/highway.h>

#include "firmware/stripe/fast_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace stria::fast::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::CappedTag<float, kLanes>;
using DI = hn::RebindToSigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
using MF = hn::Mask<DF>;

constexpr float kReach = 20.25f;  // squared widths from the middle beyond which a pulse is dark

HWY_INLINE VF constant(float value) { return hn::Set(DF(), value); }

/// 1 / v to 2e-4, which is enough for a weight: Newton's method from a guess by the exponent.
HWY_INLINE VF rough_reciprocal(VF v) {
    const VF two = constant(2.0f);
    VF x = hn::BitCast(DF(), hn::Sub(hn::Set(DI(), 0x7ef311c3), hn::BitCast(DI(), v)));
    x = hn::Mul(x, hn::Sub(two, hn::Mul(v, x)));
    return hn::Mul(x, hn::Sub(two, hn::Mul(v, x)));
}

/// exp(-u / 2) for 0 <= u <= kReach, to 2e-5 of itself: the 64th power of a polynomial for
/// exp(-u / 128), minimax of its relative error. Beyond: any number.
HWY_INLINE VF bell(VF u) {
    VF p = hn::Sub(constant(3.04409898e-5f), hn::Mul(u, constant(7.34056682e-8f)));
    p = hn::Sub(hn::Mul(u, p), constant(7.81218636e-3f));
    p = hn::Add(hn::Mul(u, p), constant(0.999999796f));
    for (int i = 0; i < 6; ++i) p = hn::Mul(p, p);
    return p;
}

/// The model of the lanes' pulses. Its width is that of the exposed pulse, w^2 + h^2 / 3.
class Model {
  public:
    HWY_INLINE Model() {}  // not implied: an implied one is compiled for no instruction set
    HWY_INLINE Model(VF its_height, VF its_position, VF its_width, VF its_level)
        : height(its_height), position(its_position), width(its_width), level(its_level) {}
    VF height, position, width, level;
};

/// Weighted sums over a window of products of the model's slopes by (log height, log width, level,
/// position / width), which are (f, f u, 1, f z), f the pulse, z = (x - position) / width, u = z^2;
/// and of them with the residual r.
class Sums {
  public:
    HWY_INLINE Sums()
        : ff(constant(0)),
          ffz(ff),
          ffu(ff),
          ffuz(ff),
          ffuu(ff),
          f(ff),
          fz(ff),
          fu(ff),
          one(ff),
          rf(ff),
          rfz(ff),
          rfu(ff),
          r(ff),
          rr(ff),
          squares(ff),
          last(ff),
          before(ff),
          greatest(ff) {}
    VF ff, ffz, ffu, ffuz, ffuu;  ///< f f with powers of z
    VF f, fz, fu, one;
    VF rf, rfz, rfu, r;
    VF rr, squares;             ///< r r, weighted and not
    VF last, before, greatest;  ///< residuals; the greatest, smoothed over three samples, times 4

    /// Notes the next residual, 0 outside of a lane's window.
    HWY_INLINE void note(VF residual) {
        const VF smooth = hn::Add(hn::Add(before, residual), hn::Add(last, last));
        greatest = hn::Max(greatest, smooth);
        before = last;
        last = residual;
    }
    /// Adds a sample of the pulse: w f, f, z, u, w r f.
    template <bool kMatrix>
    HWY_INLINE void add_pulse(VF wf, VF f_, VF z, VF u, VF residual) {
        VF t = hn::Mul(wf, residual);
        rf = hn::Add(rf, t);
        rfz = hn::Add(rfz, hn::Mul(t, z));
        rfu = hn::Add(rfu, hn::Mul(t, u));
        if (!kMatrix) return;
        f = hn::Add(f, wf);
        fz = hn::Add(fz, hn::Mul(wf, z));
        fu = hn::Add(fu, hn::Mul(wf, u));
        const VF w2 = hn::Mul(wf, f_);
        const VF w2u = hn::Mul(w2, u);
        ff = hn::Add(ff, w2);
        ffz = hn::Add(ffz, hn::Mul(w2, z));
        ffu = hn::Add(ffu, w2u);
        ffuz = hn::Add(ffuz, hn::Mul(w2u, z));
        ffuu = hn::Add(ffuu, hn::Mul(w2u, u));
    }
};

/// A step of the parameters, in the order of Sums' slopes, and how much the deviance falls by it.
class Step {
  public:
    HWY_INLINE Step() {}
    VF height, width, level, place, decrease;
};

/// The normal equations' matrix, factored as L D L'.
class Factor {
  public:
    HWY_INLINE Factor()
        : i0_(constant(0)),
          i1_(i0_),
          i2_(i0_),
          i3_(i0_),
          l1_(i0_),
          l2_(i0_),
          l3_(i0_),
          m2_(i0_),
          m3_(i0_),
          n3_(i0_),
          a12_(i0_),
          a13_(i0_),
          a23_(i0_),
          held_(hn::Ne(i0_, i0_)) {}
    /// `held`: lanes whose width stays as it is.
    HWY_INLINE Factor(const Sums& s, MF held) : held_(held) {
        const VF one = constant(1.0f), none = constant(0.0f);
        const VF ffu = hn::IfThenElse(held, none, s.ffu);
        const VF ffuu = hn::IfThenElse(held, one, s.ffuu);
        const VF fu = hn::IfThenElse(held, none, s.fu);
        const VF ffuz = hn::IfThenElse(held, none, s.ffuz);
        i0_ = hn::Div(one, s.ff);
        l1_ = hn::Mul(ffu, i0_);
        l2_ = hn::Mul(s.f, i0_);
        l3_ = hn::Mul(s.ffz, i0_);
        const VF a11 = hn::Sub(ffuu, hn::Mul(l1_, ffu));
        a12_ = hn::Sub(fu, hn::Mul(l1_, s.f));
        a13_ = hn::Sub(ffuz, hn::Mul(l1_, s.ffz));
        i1_ = hn::Div(one, a11);
        m2_ = hn::Mul(a12_, i1_);
        m3_ = hn::Mul(a13_, i1_);
        const VF a22 = hn::Sub(hn::Sub(s.one, hn::Mul(l2_, s.f)), hn::Mul(m2_, a12_));
        a23_ = hn::Sub(hn::Sub(s.fz, hn::Mul(l2_, s.ffz)), hn::Mul(m2_, a13_));
        i2_ = hn::Div(one, a22);
        n3_ = hn::Mul(a23_, i2_);
        const VF a33 = hn::Sub(hn::Sub(s.ffu, hn::Mul(l3_, s.ffz)), hn::Mul(m3_, a13_));
        i3_ = hn::Div(one, hn::Sub(a33, hn::Mul(n3_, a23_)));
    }

    HWY_INLINE Step solve(const Sums& s) const {
        const VF rfu = hn::IfThenElse(held_, constant(0.0f), s.rfu);
        const VF g1 = hn::Sub(rfu, hn::Mul(l1_, s.rf));
        const VF g2 = hn::Sub(hn::Sub(s.r, hn::Mul(l2_, s.rf)), hn::Mul(m2_, g1));
        const VF g3 = hn::Sub(hn::Sub(hn::Sub(s.rfz, hn::Mul(l3_, s.rf)), hn::Mul(m3_, g1)),
                              hn::Mul(n3_, g2));
        Step d;
        d.place = hn::Mul(g3, i3_);
        d.level = hn::Mul(hn::Sub(g2, hn::Mul(a23_, d.place)), i2_);
        d.width =
            hn::Mul(hn::Sub(hn::Sub(g1, hn::Mul(a12_, d.level)), hn::Mul(a13_, d.place)), i1_);
        d.height = hn::Sub(
            hn::Sub(hn::Sub(hn::Mul(s.rf, i0_), hn::Mul(l1_, d.width)), hn::Mul(l2_, d.level)),
            hn::Mul(l3_, d.place));
        d.decrease = hn::Add(hn::Add(hn::Mul(d.height, s.rf), hn::Mul(d.width, rfu)),
                             hn::Add(hn::Mul(d.level, s.r), hn::Mul(d.place, s.rfz)));
        return d;
    }

    /// Variances: of position / width, and of the height's logarithm, the first unit vector's
    /// element of the inverse.
    HWY_INLINE VF place_variance() const { return i3_; }
    HWY_INLINE VF height_variance() const {
        const VF y2 = hn::Sub(hn::Mul(m2_, l1_), l2_);
        const VF y3 = hn::Sub(hn::Sub(hn::Mul(m3_, l1_), l3_), hn::Mul(n3_, y2));
        return hn::Add(hn::Add(i0_, hn::Mul(hn::Mul(l1_, l1_), i1_)),
                       hn::Add(hn::Mul(hn::Mul(y2, y2), i2_), hn::Mul(hn::Mul(y3, y3), i3_)));
    }

  private:
    VF i0_, i1_, i2_, i3_;  ///< 1 / D
    VF l1_, l2_, l3_, m2_, m3_, n3_, a12_, a13_, a23_;
    MF held_;
};

}  // namespace stria::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
