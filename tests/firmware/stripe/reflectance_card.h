#pragma once
#include <vector>

#include "firmware/core/frame.h"
#include "firmware/core/sensor_noise.h"

namespace stria::test {

/// A card across which a Gaussian beam sweeps, noise-free and in closed form. All lengths in pixels
/// of the camera on the card. Each row is a card of its own, its edge an eighth of a pixel further.
struct ReflectanceCard {
    double contrast = 10;    ///< K: reflectance 1 left of the edge, 1 / K right of it
    double beam_width = 6;   ///< sigma_b, standard deviation on the card
    double footprint = 0.8;  ///< sigma_p: a Gaussian's, pixel included; or
    double box = 0;          ///< above 0: a sharp camera's pixel of this length instead
    double beam_step = 1;    ///< of the beam between frames

    static constexpr int kRows = 8;
    static constexpr TimeNs kPeriodNs = 5'000'000;  ///< from frame to frame
    static constexpr double kHeight = 30000;        ///< DN, 16 bits

    double edge(int row) const { return 0.5 * width() + row / static_cast<double>(kRows); }
    int width() const;   ///< of a frame: ten beam widths on either side of the edge
    int frames() const;  ///< seven beam widths on either side of the edge
    double beam_at(double frame) const;
    double beam_at_time(TimeNs t_ns) const;  ///< of the middle of an exposure, from frame 0's start
    /// Light in the pixel at x while the beam is at x_beam, over that without the edge at the top.
    double light(double x, double x_beam, double edge) const;
    Frame frame(int k) const;
};

/// Greatest error of the mean of a Gaussian of width 1 whose right part is weighted with 1 / K,
/// over all places of the edge: max (1 - 1/K) phi(d) / (Phi(d) + (1 - Phi(d)) / K).
double greatest_shift(double contrast);

/// Greatest errors (px on the card) near the edge.
struct CardErrors {
    double spatial_moment = 0;    ///< centre of gravity of every frame's row
    double spacetime_moment = 0;  ///< and of every pixel's samples over time
    std::vector<double> spatial;  ///< find_peaks by each of kPeakMethods
    double spacetime = 0;         ///< SpacetimeAnalyser
    std::size_t pulses = 0;       ///< spacetime pulses compared
    std::size_t pixels = 0;       ///< whose footprint the edge touches: one pulse each
};
CardErrors measure(const ReflectanceCard& card);
/// The part of it over time, of other frames than the card's own.
void measure_spacetime(const ReflectanceCard& card, const std::vector<Frame>& frames,
                       const SensorNoise& noise, CardErrors& errors);

}  // namespace stria::test
