#pragma once
#include "firmware/core/pulse.h"
#include "host/io/image_io.h"

namespace stria {

/// The channel that rises most above the other two somewhere (99.9th percentile): red, green or
/// blue, or grey where none does by 2 % of full scale. Not always the one that shows the stripe
/// best: a bright stripe clips in its own colour first.
ColourChannel laser_colour(const LoadedImage& image);

/// Tells the laser's light from bright edges in a colour photograph: where a stripe is, the laser's
/// channel rises above the other two by more than it does beside it; a bright edge raises all
/// three.
class LaserColour {
  public:
    /// Of an image without colour: takes every peak for the laser's.
    LaserColour() = default;
    /// @param laser    colour of the laser; grey: every peak is taken
    /// @param columns  peaks are those of the transposed image
    LaserColour(LoadedImage image, ColourChannel laser, bool columns);

    /// True if the peak's own light has the laser's colour: the rise of the excess (laser's channel
    /// minus the greater of the others) is a quarter of the peak's height at least. Where samples
    /// are nearly clipped, and have therefore lost their colour, the light beside them counts.
    bool has(const Pulse& peak) const;

  private:
    double level(int x, int y) const;   ///< of the laser's channel, 0 to 1
    double excess(int x, int y) const;  ///< DN, mean of five rows unless clipped
    double excess_of_rows(int x, int y) const;

    LoadedImage image_;
    int laser_ = -1;
    bool columns_ = false;
    int width_ = 0, height_ = 0;
};

}  // namespace stria
