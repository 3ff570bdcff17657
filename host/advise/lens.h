#pragma once

/// What a camera's lens does to a surface point: how large a pixel is there and how wide the
/// footprint that one pixel averages over. Thin lens; object distances from the optical centre.
namespace stria {

/// A lens and its pixel. The image distance v follows from focal length and focus:
/// 1/v = 1/f - 1/focus.
struct Lens {
    double focal_mm = 0;
    double focus_mm = 0;       ///< distance that is sharp, above focal_mm
    double f_number = 0;       ///< focal length over the diameter of the aperture
    double pixel_um = 0;       ///< side of a pixel
    double aberration_px = 0;  ///< standard deviation of the blur that aberrations add
};

/// Focal length (mm) that images `field_mm` at `distance_mm` onto `sensor_mm`:
/// f = d m / (1 + m), m = sensor / field. Source: thin-lens equation, 1/f = 1/d + 1/(m d).
double focal_length_mm(double sensor_mm, double field_mm, double distance_mm);
/// The lens of a calibrated camera: v = fx pixel, hence f = v focus / (v + focus).
Lens lens_of(double fx_px, double pixel_um, double f_number, double focus_mm);

/// v = f focus / (focus - f), mm.
double image_distance_mm(const Lens& lens);
/// f-number of the light at the sensor, N (1 + m) with m = v / focus.
double working_f_number(const Lens& lens);
/// f / N, mm.
double aperture_mm(const Lens& lens);
/// Side of a pixel on a surface that faces the camera at `depth_mm`: p depth / v, mm.
double pixel_on_object_mm(const Lens& lens, double depth_mm);
/// Sine of half the angle under which a point at `depth_mm` sees the aperture.
double sin_aperture(const Lens& lens, double depth_mm);

/// Standard deviations (mm, on a surface that faces the camera) of what one pixel averages over.
struct Footprint {
    double diffraction_mm = 0;  ///< 0.42 lambda N(1 + m) in the image (accuracy.md C, lens PSF)
    double defocus_mm = 0;      ///< a uniform disc of diameter (f/N) |z - focus| / focus: a quarter
    double aberration_mm = 0;
    double pixel_mm = 0;      ///< a box: side / sqrt(12)
    double lens_mm() const;   ///< the first three, in quadrature
    double sigma_mm() const;  ///< all: sigma_p of accuracy.md
};
Footprint footprint_at(const Lens& lens, double wavelength_nm, double depth_mm);

}  // namespace stria
