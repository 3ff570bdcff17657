#pragma once
#include <array>
#include <vector>

#include "sim/scene.h"
#include "sim/stripe_light.h"

namespace stria {

/// What one sample of a surface does to the sheet's light besides scattering it where it falls.
struct LightShape {
    float inside =
        0;            ///< share of its light that comes out of the material beside where it went in
    float shift = 0;  ///< of that light's centre along the sheet's normal, beam standard deviations
    float spread = 0;  ///< the material's free path across the sheet, beam standard deviations
    float way = 1;     ///< +1 or -1: the sample's distance from the sheet (positive on the side of
                       ///< its normal) grows or falls with s
};

/// Turns the light of one sample into Gaussians of s: the sheet's profile (SceneLine::lobe) and
/// light that comes out beside where it went in (SceneObject::subsurface). What leaves a surface
/// at distance r of where its centre lies falls as exp(-r / l) / (2 pi l^2): a mixture of Gaussians
/// whose variance is l^2 times a chi-squared number of three degrees of freedom. Six of them stand
/// for it: 3 % of the peak off at most for a sheet without width, 1 % for one as wide as l; power
/// and variance exact.
class LightParts {
  public:
    explicit LightParts(const Scene& scene);

    /// False: every light stays the one Gaussian that it is.
    bool is_shaped() const { return has_lobe_ || has_inside_; }
    bool has_inside() const { return has_inside_; }

    /// Appends what becomes of `light`, whose per_s is the beam's own and whose rate is that of its
    /// peak.
    /// @param footprint2  variance of the sheet's distance over the sample, in beam variances
    void add(const StripeLight& light, double footprint2, const LightShape& shape,
             std::vector<StripeLight>& lights) const;

  private:
    struct Component {
        double peak = 1, shift = 0, width = 1;  ///< of the beam's; the last two its deviations
    };
    void add_part(const StripeLight& light, const Component& part, double extra2, double share,
                  const LightShape& shape, double shift, std::vector<StripeLight>& lights) const;

    std::array<Component, 2> profile_;
    bool has_lobe_ = false, has_inside_ = false;
};

}  // namespace stria
