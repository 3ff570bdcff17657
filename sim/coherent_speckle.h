#pragma once
#include <complex>
#include <cstdint>
#include <limits>
#include <vector>

#include "sim/fourier.h"

namespace stria {

/// A camera with a circular aperture before a rough surface. Lengths in mm on the surface.
struct CoherentView {
    double wavelength_nm = 650;
    double sin_u = 0.005;  ///< half aperture seen from the surface, above 0, below 1
    /// Share of the aperture's radius over which its transmission (of amplitude) falls from 1 to 0
    /// as a raised cosine about the radius, 0..1; 0: a sharp edge, as an iris has it.
    double soft_edge = 0;
    double pixel_mm = 0.1;  ///< side of a square pixel's picture on the surface
    int columns = 64;       ///< pixels, across the stripe; a power of two
    int rows = 8;           ///< pixels, along the stripe; a power of two
    /// The cross-section model: every row of pixels is a surface of its own, whose light spreads
    /// along the row alone, by the kernel 2 J1(v) / v, v = 2 pi sin u x / lambda, the middle of the
    /// aperture's picture of a point. It lacks what the far rings bring from above and below.
    bool cross_section = false;
};

/// Cross-section of the laser's line where it meets the surface.
struct CoherentLine {
    double sigma_mm = 0.3;  ///< standard deviation of the intensity
    /// Distance from the surface to the point about which the beam turns; infinite: it shifts.
    double turning_mm = std::numeric_limits<double>::infinity();
    /// Radius of the wavefront there, positive if it comes from a waist before the surface;
    /// infinite at the waist.
    double wavefront_mm = std::numeric_limits<double>::infinity();
};

/// Light of coherent speckle on a patch of rough surface while a laser line crosses it: the scalar
/// field E(q) = sum over x, y of r(x, y) a(x - x_b) exp(i phase) h(q - (x, y)), with r complex
/// circular Gaussian and white, a = exp(-d^2 / (4 sigma^2)) with d = x - x_b, and h the picture of
/// a point through the circular aperture, a disc of radius sin u / lambda in spatial frequency
/// (Goodman, Speckle Phenomena in Optics, 2007, ch. 4). Polarised light, surface across both line
/// of sight and beam, the patch cyclic in both directions.
///
/// Phase: a beam that turns about a point at distance D and reaches the surface with wavefront
/// radius R has k (x_b d / D + d^2 / (2 R)) against its centre. As x_b d = (x^2 - x_b^2 - d^2) / 2,
/// that is k d^2 (1 / R - 1 / D) / 2, a phase of each scatterer's own and one of each moment, both
/// without effect: at R = D the speckle stays as it is while the line crosses.
class CoherentSurface {
  public:
    /// Throws std::invalid_argument: field, value, bound.
    CoherentSurface(const CoherentView& view, std::uint64_t seed);

    /// Speckle's size lambda / (2 sin u), mm.
    double rho_mm() const { return rho_mm_; }
    double width_mm() const { return columns_mm_; }
    double cell_mm() const { return cell_mm_; }  ///< at most rho / 4
    int cell_columns() const { return static_cast<int>(along_x_.length()); }
    int cell_rows() const { return static_cast<int>(along_y_.length()); }
    int cells_a_pixel() const { return cells_a_pixel_; }

    /// Intensity in every cell, row by row, where an even plane wave lights all; its expectation
    /// is 1.
    std::vector<double> evenly_lit() const;
    /// The same where the line's centre is at x = centre_mm; its expectation is 1 at the centre.
    std::vector<double> lit_by(const CoherentLine& line, double centre_mm) const;
    /// Means over the pixels of what the two return: view.columns x view.rows, row by row. Column
    /// c covers x from c pixel_mm to (c + 1) pixel_mm, cells being centred on whole x / cell_mm +
    /// 1/2.
    std::vector<double> pixels_of(const std::vector<double>& cells) const;

  private:
    /// Write rows_; return the sum of squared transmissions.
    double make_aperture();
    double make_sections();
    std::vector<double> intensity(const std::vector<std::complex<double>>& light) const;

    CoherentView view_;
    double rho_mm_, cell_mm_, columns_mm_;
    int cells_a_pixel_;
    Fourier along_x_, along_y_;
    /// Rows of spatial frequency along y that pass the aperture: as white as the scatterers
    /// themselves, since a transform of white noise is white; light never depends on y. Of a
    /// cross-section: its surfaces.
    struct Row {
        std::size_t frequency;             ///< index in along_y_, or of the surface
        std::vector<double> transmission;  ///< of frequencies 0, 1 .. along x; the rest is 0
    };
    std::vector<Row> rows_;
    std::vector<std::complex<double>> scatterers_;  ///< cell_columns a row of rows_
    double scale_;                                  ///< to expectation 1
};

}  // namespace stria
