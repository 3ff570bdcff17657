// What the fast kernels make of a fit, for one instruction set; included once for each by
// fast_kernels.cpp.
#if defined(STRIA_FAST_JUDGE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef STRIA_FAST_JUDGE_INL
#undef STRIA_FAST_JUDGE_INL
#else
#define STRIA_FAST_JUDGE_INL
#endif

#include <hwy/highway.h>

#include <cstring>

#include "firmware/stripe/fast_kernels.h"
#include "firmware/stripe/fast_sums-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stria::fast::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The kernel judges what is clearly on one side of a limit of the reference's; shares of the
// limits.
constexpr float kNarrowest = 0.55f;  // frame periods; the kernel's aperture is exact enough above
constexpr float kLongEnough = 16;    // samples of a window whose misfit can be called noise
// Heights in two standard deviations of the background: weaker pulses can be fitted in several
// ways.
constexpr float kStrong = 4.0f, kVeryStrong = 10.0f;
// Widths (periods) below which a misfit may be one of two ways between few samples, so that the
// kernel judges what fits well only; and that a window must be long so that height, width and
// background are known apart.
constexpr float kNarrow = 0.8f, kWindowWidths = 5.0f;
// Share of chi-square about its limit that is left to the reference: of pulses of 50 times the
// noise and less, and of 200 times and more.
constexpr float kLeastDoubt = 5e-4f, kMostDoubt = 2e-3f;
constexpr float kClearlyPlaced = 0.3f;  // sigma over width: more is where frames are missing
constexpr float kClearlyAbove = 1.03f, kClearlyBelow = 0.97f;

/// False: one variance for all of a window's samples, where it changes by less than a thousandth.
HWY_INLINE bool has_shot_noise(const FitTask& task) {
    return 255.0f * task.variance_gain >= 1e-3f * task.variance_floor;
}

/// The lanes' windows, and what their samples say without a fit.
class LaneWindows {
  public:
    HWY_INLINE LaneWindows(const FitTask& task, int its_lane)
        : lane(its_lane),
          begin(hn::Sub(hn::LoadU(DI(), task.windows->begin + lane),
                        hn::Set(DI(), task.windows->first))),
          end(hn::Sub(hn::LoadU(DI(), task.windows->end + lane),
                      hn::Set(DI(), task.windows->first))),
          count(hn::ConvertTo(DF(), hn::Sub(end, begin))),
          held(hn::Gt(count, constant(0.0f))),
          background(hn::LoadU(DF(), task.windows->background + lane)),
          variance(
              hn::Add(constant(task.variance_floor),
                      hn::Mul(constant(task.variance_gain),
                              hn::Max(hn::Sub(background, constant(task.black)), constant(0.0f))))),
          noise(hn::Sqrt(variance)),
          least(hn::Add(noise, noise)),
          smallest(
              hn::Max(constant(task.min_amplitude_dn), hn::Mul(constant(task.min_snr), noise))),
          peak(noise),
          asked(held) {}

    /// Greatest sample and greatest sum of two successive ones, DN above the tracked background.
    HWY_INLINE void note(VF its_peak, VF pair) {
        peak = its_peak;
        asked = hn::And(held, hn::Ge(pair, hn::Mul(constant(1.05f), smallest)));
    }
    HWY_INLINE void count_effective(VF samples, FitTask& out) const {
        const DF d;
        const VF level = hn::LoadU(d, out.windows->level + lane);
        const MF counted =
            hn::And(held, hn::Ge(peak, hn::Mul(constant(2.0f), hn::Sub(level, background))));
        const VF bin =
            hn::Add(hn::Mul(hn::Sub(samples, constant(1.0f)), constant(20.0f)), constant(0.5f));
        const VF last = constant(kSampleBins - 1), none = constant(kSampleBins);
        hn::StoreU(hn::ConvertTo(DI(), hn::IfThenElse(counted, hn::Min(bin, last), none)), DI(),
                   out.effective_bin + lane);
    }

    const int lane;
    const VI begin, end;  ///< samples from the group's first on; equal: no window
    const VF count;
    const MF held;        ///< lanes with a window
    const VF background;  ///< DN, as tracked; below: DN above it
    const VF variance, noise;
    const VF least;     ///< of a sample of a pulse
    const VF smallest;  ///< height of a pulse
    VF peak;
    MF asked;  ///< windows that may hold a pulse
};

/// The lanes' fits so far, and the verdict about them.
class Found {
  public:
    HWY_INLINE explicit Found(const LaneWindows& lanes)
        : lanes_(lanes),
          per_degree_(hn::Div(constant(1.0f),
                              hn::Max(hn::Sub(lanes.count, constant(4.0f)), constant(1.0f)))),
          spread_(hn::Sqrt(hn::Add(per_degree_, per_degree_))),
          chi_square_(constant(0.0f)),
          squares_(chi_square_),
          place_variance_(chi_square_),
          height_variance_(chi_square_),
          greatest_(chi_square_),
          energy_(chi_square_) {
        model = Model(chi_square_, chi_square_, chi_square_, chi_square_);
    }

    /// For the lanes `open`: a better model, its chi-square and the sum of squared residuals, the
    /// variances of position / width and of the height's logarithm, for a pulse of that energy.
    HWY_INLINE void note(MF open, const Model& next, VF chi_square, VF squares, VF place_variance,
                         VF height_variance, VF energy) {
        model.height = hn::IfThenElse(open, next.height, model.height);
        model.position = hn::IfThenElse(open, next.position, model.position);
        model.width = hn::IfThenElse(open, next.width, model.width);
        model.level = hn::IfThenElse(open, next.level, model.level);
        chi_square_ = hn::IfThenElse(open, hn::Mul(chi_square, per_degree_), chi_square_);
        squares_ = hn::IfThenElse(open, squares, squares_);
        place_variance_ = hn::IfThenElse(open, place_variance, place_variance_);
        height_variance_ = hn::IfThenElse(open, height_variance, height_variance_);
        energy_ = hn::IfThenElse(open, energy, energy_);
    }
    HWY_INLINE void note_residual(MF open, VF greatest) {
        greatest_ = hn::IfThenElse(open, hn::Mul(greatest, constant(0.25f)), greatest_);
    }
    /// Chi-square that one in thirty exceeds, and less: nobody asks for the residuals.
    HWY_INLINE MF is_inconspicuous() const {
        return hn::Lt(chi_square_, hn::Add(constant(1.0f), hn::Add(spread_, spread_)));
    }

    /// A pulse that does not fit well, or one between few samples: its fit settles slowly.
    HWY_INLINE MF is_doubtful(const FitTask& task) const {
        return hn::Not(hn::And(fits_well(), hn::Ge(model.width, constant(kNarrow * task.period))));
    }

    /// Writes the lanes' results and what they are taken for. `open`: those that did not converge.
    HWY_INLINE void report(FitTask& out, MF open) {
        const DF d;
        const VF blur = constant(out.half_aperture * out.half_aperture / 3.0f);
        const VF square = hn::Sub(hn::Mul(model.width, model.width), blur);
        // Both variances fall with the pulse's energy.
        const VF less = hn::Div(energy_, hn::Mul(hn::Mul(model.height, model.height), model.width));
        height_variance_ = hn::Mul(height_variance_, less);
        width_ = hn::Sqrt(hn::Max(square, constant(0.01f)));
        sigma_ = hn::Mul(model.width, hn::Sqrt(hn::Mul(place_variance_, less)));
        amplitude_ = hn::Div(hn::Mul(model.height, model.width), width_);
        VF sigma = hn::Mul(sigma_, constant(out.period_ns));
        const MF inflated = hn::Gt(chi_square_, significant());
        if (!hn::AllFalse(d, inflated))
            sigma = hn::IfThenElse(inflated, hn::Mul(sigma, hn::Sqrt(chi_square_)), sigma);
        hn::StoreU(sigma, d, out.sigma + lanes_.lane);
        hn::StoreU(hn::Mul(width_, constant(out.period_ns)), d, out.width + lanes_.lane);
        hn::StoreU(amplitude_, d, out.amplitude + lanes_.lane);
        hn::StoreU(model.level, d, out.level + lanes_.lane);
        hn::StoreU(chi_square_, d, out.chi_square + lanes_.lane);

        const MF sound = hn::AndNot(open, hn::Ge(square, constant(0.01f)));
        const MF sure =
            hn::And(hn::And(sound, hn::And(is_clean(out), is_single(out))), is_certain(out));
        hn::StoreU(hn::IfThenElseZero(sure, model.position), d, out.position + lanes_.lane);
        out.lanes |= bits(lanes_.held) << lanes_.lane;
        out.pulses |= bits(hn::And(lanes_.asked, sure)) << lanes_.lane;
        out.unsure |= bits(hn::AndNot(sure, lanes_.asked)) << lanes_.lane;
    }

    Model model;

  private:
    /// A chi-square that one in six exceeds, and less.
    HWY_INLINE MF fits_well() const {
        return hn::Lt(chi_square_, hn::Add(constant(1.0f), spread_));
    }
    HWY_INLINE VF significant() const {
        return hn::Add(constant(1.0f), hn::Mul(constant(3.0f), spread_));
    }
    /// Share of chi-square that the kernel may miss the reference's by: its shape's errors grow
    /// with the height over the noise; with shot noise its weights have errors of their own.
    HWY_INLINE VF doubt(const FitTask& task) const {
        if (has_shot_noise(task)) return constant(kMostDoubt);
        const VF share = hn::Clamp(hn::Mul(constant(2e-5f), hn::Div(model.height, lanes_.least)),
                                   constant(kLeastDoubt), constant(kMostDoubt));
        return hn::IfThenElse(hn::Ge(lanes_.count, constant(kLongEnough)), share,
                              constant(kMostDoubt));
    }
    static HWY_INLINE std::uint32_t bits(MF mask) {
        std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(DF(), mask, bytes);
        return std::uint32_t{bytes[0]} | (std::uint32_t{bytes[1]} << 8);
    }

    /// Not clipped, inside of the window, and of a width that the kernel's aperture is exact for.
    HWY_INLINE MF is_clean(const FitTask& task) const {
        const DF d;
        const VF period = constant(task.period);
        const VI last = hn::Max(hn::Sub(lanes_.end, hn::Set(DI(), 1)), lanes_.begin);
        const VI none = hn::Zero(DI());  // lanes without a window read some time
        const MF inside = hn::And(
            hn::Gt(model.position,
                   hn::Add(hn::GatherIndex(d, task.x, hn::Max(lanes_.begin, none)), period)),
            hn::Lt(model.position,
                   hn::Sub(hn::GatherIndex(d, task.x, hn::Max(last, none)), period)));
        const VF longest = hn::Min(constant(0.6f * task.max_width),
                                   hn::Mul(lanes_.count, constant(task.period / kWindowWidths)));
        const MF wide =
            hn::And(hn::Gt(width_, constant(kNarrowest * task.period)), hn::Lt(width_, longest));
        const MF clipped = hn::Ge(hn::Add(lanes_.peak, lanes_.background), constant(255.0f));
        return hn::AndNot(clipped, hn::And(inside, wide));
    }

    /// True if the reference's fit, too, would leave it at a single pulse: the misfit is what noise
    /// makes of one in some hundred strong pulses, and nothing is left over that may be another.
    HWY_INLINE MF is_single(const FitTask& task) const {
        const VF limit = significant();
        const VF unsure = hn::Mul(doubt(task), limit);
        const MF quiet = hn::Lt(chi_square_, hn::Sub(limit, unsure));
        const MF noise =
            hn::And(hn::And(hn::Gt(chi_square_, hn::Add(limit, unsure)),
                            hn::Le(chi_square_, hn::Mul(constant(1.5f), limit))),
                    hn::And(hn::Ge(model.height, hn::Mul(constant(kVeryStrong), lanes_.least)),
                            hn::Ge(lanes_.count, constant(kLongEnough))));
        const MF nothing_left = hn::Lt(greatest_, hn::Mul(constant(0.45f), lanes_.smallest));
        const MF many_samples = hn::Ge(width_, constant(kNarrow * task.period));
        return hn::Or(hn::And(is_inconspicuous(), hn::Or(many_samples, fits_well())),
                      hn::And(hn::And(hn::Or(quiet, noise), nothing_left), many_samples));
    }

    /// Sure of a pulse, never of none: the reference may find a narrow one between the samples. A
    /// weak pulse over black, where the noise's slope has a bend, may have two solutions.
    HWY_INLINE MF is_certain(const FitTask& task) const {
        const VF height = model.height;
        const MF dark = hn::And(hn::Lt(hn::Sub(model.level, constant(task.black)),
                                       hn::Mul(constant(0.5f), lanes_.least)),
                                hn::Lt(height, hn::Mul(constant(kVeryStrong), lanes_.least)));
        const MF strong =
            hn::And(hn::Ge(height, hn::Mul(constant(kStrong), lanes_.least)),
                    hn::Gt(height, hn::Mul(constant(kClearlyAbove), lanes_.smallest)));
        const VF misfit = hn::Mul(constant(kClearlyBelow * task.max_misfit), amplitude_);
        const MF placed =
            hn::And(hn::Lt(sigma_, hn::Mul(constant(kClearlyPlaced), width_)),
                    hn::Lt(hn::Mul(constant(16.0f), height_variance_), constant(1.0f)));
        return hn::And(
            hn::AndNot(dark, strong),
            hn::And(placed, hn::Lt(squares_, hn::Mul(lanes_.count, hn::Mul(misfit, misfit)))));
    }

    const LaneWindows& lanes_;
    const VF per_degree_, spread_;
    VF chi_square_, squares_, place_variance_, height_variance_, greatest_, energy_;
    VF width_, sigma_, amplitude_;
};

}  // namespace stria::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
