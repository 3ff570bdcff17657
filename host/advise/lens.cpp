#include "host/advise/lens.h"

#include <cmath>

namespace stria {

double focal_length_mm(double sensor_mm, double field_mm, double distance_mm) {
    const double m = sensor_mm / field_mm;
    return distance_mm * m / (1 + m);
}

Lens lens_of(double fx_px, double pixel_um, double f_number, double focus_mm) {
    const double v = fx_px * pixel_um * 1e-3;
    return {.focal_mm = v * focus_mm / (v + focus_mm),
            .focus_mm = focus_mm,
            .f_number = f_number,
            .pixel_um = pixel_um};
}

double image_distance_mm(const Lens& lens) {
    return lens.focal_mm * lens.focus_mm / (lens.focus_mm - lens.focal_mm);
}

double working_f_number(const Lens& lens) {
    return lens.f_number * (1 + image_distance_mm(lens) / lens.focus_mm);
}

double aperture_mm(const Lens& lens) { return lens.focal_mm / lens.f_number; }

double pixel_on_object_mm(const Lens& lens, double depth_mm) {
    return lens.pixel_um * 1e-3 * depth_mm / image_distance_mm(lens);
}

double sin_aperture(const Lens& lens, double depth_mm) {
    const double radius_mm = aperture_mm(lens) / 2;
    return radius_mm / std::hypot(radius_mm, depth_mm);
}

double Footprint::lens_mm() const { return std::hypot(diffraction_mm, defocus_mm, aberration_mm); }
double Footprint::sigma_mm() const { return std::hypot(lens_mm(), pixel_mm); }

Footprint footprint_at(const Lens& lens, double wavelength_nm, double depth_mm) {
    const double object_per_image = depth_mm / image_distance_mm(lens);
    const double pixel_mm = pixel_on_object_mm(lens, depth_mm);
    Footprint print;
    print.diffraction_mm = 0.42 * wavelength_nm * 1e-6 * working_f_number(lens) * object_per_image;
    print.defocus_mm = aperture_mm(lens) * std::abs(depth_mm - lens.focus_mm) / lens.focus_mm / 4;
    print.aberration_mm = lens.aberration_px * pixel_mm;
    print.pixel_mm = pixel_mm / std::sqrt(12.0);
    return print;
}

}  // namespace stria
