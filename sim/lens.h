#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "host/core/camera_model.h"
#include "sim/scene.h"

namespace stria {

/// Standard deviation (px) of the spot that a point at depth z_mm (camera frame) makes: the lens's
/// own psf_sigma_px, and with focus_mm > 0 its circle of confusion. That is a disc of diameter
/// c = (f / N) f |z - focus| / (z (focus - f)), f = fx pixel_um, N = f_number (thin lens), replaced
/// by the Gaussian of equal second moment, standard deviation c / 4.
double spot_sigma_px(const Scene& scene, double z_mm);

/// Weights 0..reach of a discrete Gaussian of variance sigma_px^2, exp(-t) I_n(t), t = sigma_px^2;
/// weight n counts for +n and -n. Their sum over both sides is 1 and their variance t (both to
/// 1e-6, where the tail is cut), for any sigma down to 0. T. Lindeberg, "Scale-space for discrete
/// signals", PAMI 12(3), 1990.
std::vector<float> discrete_gaussian(double sigma_px);

/// Share of the light that the lens passes to each pixel, row by row: cos^4 of the angle from the
/// optical axis if scene.lens.cos4, times 1 - corner_loss (r / r_corner)^2, r from (cx, cy) and
/// r_corner the farthest corner.
std::vector<float> vignetting(const Scene& scene);

/// Spreads the light of every pixel by a spot of its own size; sum kept. The picture's border
/// reflects, so that an even field stays even. Where a spot overlaps a nearer surface both add up.
class SpotSpread {
  public:
    /// Largest spot: what is farther out of focus is spread by it.
    static constexpr double kMostSigma = 16;  ///< px
    static constexpr int kStepsPerPx = 64;    ///< spots are rounded to 1/64 px

    SpotSpread();
    static std::uint16_t index_of(double sigma_px);
    /// Adds to rows [row_begin, row_end) of `out`, which holds those rows only, what the picture
    /// `light` sends there. `spots`: index_of each pixel's spot. Same result for any cutting into
    /// rows.
    void gather(std::span<const float> light, std::span<const std::uint16_t> spots, int width,
                int height, int row_begin, int row_end, std::span<float> out) const;

  private:
    std::vector<std::vector<float>> kernels_;  ///< by index
};

}  // namespace stria
