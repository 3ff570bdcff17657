#pragma once

/// A laser line's cross-section along its way. Widths are standard deviations of the intensity:
/// a quarter of the full 1/e^2 width, half of the 1/e^2 radius w.
namespace stria {

struct GaussianBeam {
    double waist_sigma_mm = 0.1;
    double wavelength_nm = 650;
    double m_squared = 1;  ///< beam quality across the line, >= 1 (ISO 11146)
};

/// z_R = 4 pi sigma0^2 / (M^2 lambda), mm. accuracy.md C, beam; w0 = 2 sigma0.
double rayleigh_mm(const GaussianBeam& beam);
/// sigma0 sqrt(1 + (z / z_R)^2), mm, z from the waist. accuracy.md C.
double sigma_at_mm(const GaussianBeam& beam, double from_waist_mm);
/// Radius of the wavefront, z (1 + (z_R / z)^2), mm; infinite at the waist, negative before it.
double wavefront_radius_mm(const GaussianBeam& beam, double from_waist_mm);
/// Over how many mm the beam keeps its width to within sqrt(2): 2 z_R.
double depth_of_field_mm(const GaussianBeam& beam);
/// Narrowest waist (mm) whose beam has `sigma_mm` at `from_waist_mm`; where none is that narrow,
/// the waist sqrt(M^2 lambda z / (4 pi)) that makes it as narrow there as can be. Of the two
/// waists that fit, the narrow one has its wavefront centred nearest the waist.
double waist_for_mm(double sigma_mm, double from_waist_mm, double wavelength_nm, double m_squared);

/// D_eff of accuracy.md finding 5, mm: 1 / D_eff = |1 / turning_mm - 1 / wavefront_mm|. Either may
/// be infinite: a beam that does not turn, a plane wave. Infinite: the speckle stays frozen.
double effective_distance_mm(double turning_mm, double wavefront_mm);

}  // namespace stria
