#include "sim/coherent_speckle.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "sim/random.h"

namespace stria {
namespace {

[[noreturn]] void refuse(const std::string& field, double value, const std::string& bound) {
    throw std::invalid_argument(field + " = " + std::to_string(value) + ": expected " + bound);
}

const CoherentView& checked(const CoherentView& view) {
    const auto is_side = [](int pixels) {
        return pixels >= 1 && pixels <= 4096 && std::has_single_bit(static_cast<unsigned>(pixels));
    };
    if (!(view.wavelength_nm >= 200 && view.wavelength_nm <= 2000))
        refuse("wavelength_nm", view.wavelength_nm, "200 to 2000");
    if (!(view.sin_u > 0 && view.sin_u < 1)) refuse("sin_u", view.sin_u, "above 0, below 1");
    if (!(view.soft_edge >= 0 && view.soft_edge <= 1))
        refuse("soft_edge", view.soft_edge, "0 to 1");
    if (view.cross_section && view.soft_edge != 0)
        refuse("soft_edge", view.soft_edge, "0 in a cross-section");
    const double rho_mm = view.wavelength_nm * 1e-6 / (2 * view.sin_u);
    if (!(view.pixel_mm > 0 && view.pixel_mm <= 64 * rho_mm))
        refuse("pixel_mm", view.pixel_mm, "above 0, at most 64 speckles");
    if (!is_side(view.columns)) refuse("columns", view.columns, "a power of two, at most 4096");
    if (!is_side(view.rows)) refuse("rows", view.rows, "a power of two, at most 4096");
    return view;
}

/// Cells of at most rho / 4 that divide a pixel, a power of two.
int cells_a_pixel(const CoherentView& view) {
    const double rho_mm = view.wavelength_nm * 1e-6 / (2 * view.sin_u);
    return static_cast<int>(
        std::bit_ceil(static_cast<unsigned>(std::ceil(4 * view.pixel_mm / rho_mm))));
}

/// Of amplitude, at `radius` in radii of the aperture.
double transmission(double radius, double soft_edge) {
    const double from = 1 - soft_edge / 2;
    if (radius <= from) return 1;
    if (soft_edge == 0) return radius <= 1 ? 1 : 0;
    return 0.5 + 0.5 * std::cos(std::numbers::pi * std::min(1.0, (radius - from) / soft_edge));
}

/// What passes of the frequencies 0, 1 .. and of their negatives at the end of the line.
void filter(const std::vector<double>& transmission, std::vector<std::complex<double>>& line) {
    const std::size_t n = line.size(), passing = transmission.size();
    for (std::size_t g = 0; g < passing; ++g) {
        line[g] *= transmission[g];
        if (g > 0) line[n - g] *= transmission[g];
    }
    for (std::size_t g = passing; g <= n - passing; ++g) line[g] = 0;
}

}  // namespace

CoherentSurface::CoherentSurface(const CoherentView& view, std::uint64_t seed)
    : view_(checked(view)),
      rho_mm_(view.wavelength_nm * 1e-6 / (2 * view.sin_u)),
      columns_mm_(view.columns * view.pixel_mm),
      cells_a_pixel_(stria::cells_a_pixel(view)),
      along_x_(static_cast<std::size_t>(view.columns * cells_a_pixel_)),
      along_y_(
          static_cast<std::size_t>(view.cross_section ? view.rows : view.rows * cells_a_pixel_)) {
    cell_mm_ = view.pixel_mm / cells_a_pixel_;
    const double passing = view.cross_section ? make_sections() : make_aperture();
    scatterers_.resize(rows_.size() * along_x_.length());
    for (std::size_t i = 0; i < scatterers_.size(); ++i)
        scatterers_[i] = {counter_random::normal(seed, counter_random::kSpeckle, 2 * i),
                          counter_random::normal(seed, counter_random::kSpeckle, 2 * i + 1)};
    // Every frequency carries 2 (length) of a white row's power; all inverse transforms add up.
    scale_ = 1 / (2 * static_cast<double>(along_x_.length()) * passing);
}

double CoherentSurface::make_sections() {
    // The transform of 2 J1(v) / v is half a circle.
    const double reach = columns_mm_ / (2 * rho_mm_);
    std::vector<double> chord;
    double passing = 0;
    for (std::size_t g = 0; g < along_x_.length() / 2; ++g) {
        const double radius = static_cast<double>(g) / reach;
        if (radius > 1) break;
        chord.push_back(std::sqrt(1 - radius * radius));
        passing += (g > 0 ? 2 : 1) * chord.back() * chord.back();
    }
    for (int y = 0; y < view_.rows; ++y) rows_.push_back({static_cast<std::size_t>(y), chord});
    return passing;
}

double CoherentSurface::make_aperture() {
    const CoherentView& view = view_;
    const double reach_x = columns_mm_ / (2 * rho_mm_);
    const double reach_y = view.rows * view.pixel_mm / (2 * rho_mm_);
    const double most = 1 + view.soft_edge / 2;
    double passing = 0;
    const auto n = static_cast<std::ptrdiff_t>(along_y_.length());
    const auto top = static_cast<std::ptrdiff_t>(reach_y * most);
    for (std::ptrdiff_t f = -top; f <= top; ++f) {
        Row row{static_cast<std::size_t>((f + n) % n), {}};
        const double part_y = static_cast<double>(f) / reach_y;
        for (std::size_t g = 0; g < along_x_.length() / 2; ++g) {
            const double radius = std::hypot(static_cast<double>(g) / reach_x, part_y);
            if (radius > most) break;
            row.transmission.push_back(transmission(radius, view.soft_edge));
            passing += (g > 0 ? 2 : 1) * row.transmission.back() * row.transmission.back();
        }
        rows_.push_back(std::move(row));
    }
    return passing;
}

std::vector<double> CoherentSurface::evenly_lit() const {
    return intensity(std::vector<std::complex<double>>(along_x_.length(), 1.0));
}

std::vector<double> CoherentSurface::lit_by(const CoherentLine& line, double centre_mm) const {
    if (!(line.sigma_mm > 0 && 8 * line.sigma_mm <= columns_mm_))
        refuse("sigma_mm", line.sigma_mm, "above 0, at most an eighth of the patch");
    const double curvature = 1 / line.wavefront_mm - 1 / line.turning_mm;  // 1 / mm
    const double phase = std::numbers::pi / (view_.wavelength_nm * 1e-6) * curvature;
    std::vector<std::complex<double>> light(along_x_.length());
    for (std::size_t x = 0; x < light.size(); ++x) {
        const double d =
            std::remainder((static_cast<double>(x) + 0.5) * cell_mm_ - centre_mm, columns_mm_);
        light[x] =
            std::polar(std::exp(-d * d / (4 * line.sigma_mm * line.sigma_mm)), phase * d * d);
    }
    return intensity(light);
}

std::vector<double> CoherentSurface::intensity(
    const std::vector<std::complex<double>>& light) const {
    const std::size_t width = along_x_.length(), height = along_y_.length();
    // Column by column, frequencies along y: so that the second transform finds them together.
    std::vector<std::complex<double>> field(width * height);
    std::vector<std::complex<double>> line(width);
    for (std::size_t j = 0; j < rows_.size(); ++j) {
        const std::complex<double>* r = scatterers_.data() + j * width;
        for (std::size_t x = 0; x < width; ++x) line[x] = r[x] * light[x];
        along_x_.forward(line);
        filter(rows_[j].transmission, line);
        along_x_.inverse(line);
        for (std::size_t x = 0; x < width; ++x) field[x * height + rows_[j].frequency] = line[x];
    }
    std::vector<double> cells(width * height);
    for (std::size_t x = 0; x < width; ++x) {
        const std::span<std::complex<double>> column(field.data() + x * height, height);
        if (!view_.cross_section) along_y_.inverse(column);
        for (std::size_t y = 0; y < height; ++y)
            cells[y * width + x] = scale_ * std::norm(column[y]);
    }
    return cells;
}

std::vector<double> CoherentSurface::pixels_of(const std::vector<double>& cells) const {
    const auto each = static_cast<std::size_t>(cells_a_pixel_);
    const std::size_t along = view_.cross_section ? 1 : each;  // cells along the stripe
    const std::size_t width = along_x_.length(), height = along_y_.length();
    if (cells.size() != width * height)
        refuse("cells", static_cast<double>(cells.size()), std::to_string(width * height));
    const auto columns = static_cast<std::size_t>(view_.columns);
    std::vector<double> pixels(columns * static_cast<std::size_t>(view_.rows));
    for (std::size_t y = 0; y < height; ++y)
        for (std::size_t x = 0; x < width; ++x)
            pixels[y / along * columns + x / each] += cells[y * width + x];
    for (double& pixel : pixels) pixel /= static_cast<double>(each * along);
    return pixels;
}

}  // namespace stria
