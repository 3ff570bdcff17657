#pragma once
#include <optional>
#include <string>
#include <vector>

#include "host/report/report.h"
#include "host/verify/probing.h"
#include "host/verify/residuals.h"

/// Pictures and drawings of the verification pages.
namespace stria {

/// Values at places of a rectangle 1 wide and `height` high, as a picture about 240 pixels wide
/// whose cells are as small as the number of places allows; empty cells are white.
ColourImage scattered_picture(const std::vector<Eigen::Vector2d>& places,
                              const std::vector<float>& values, const ColourScale& scale,
                              double height = 1);

/// A sphere's residuals as seen along the middle of the measured part, the angle from it as radius.
ColourImage residual_map(const MeasuredSphere& sphere, const ColourScale& scale);

/// Appends a fit's residuals in micrometres; the scale that suits those of all maps of a page.
void add_residuals(const FormFigures& form, std::vector<float>& residuals_um);
ColourScale residual_scale(const std::vector<float>& residuals_um);

/// Residuals over the standard deviation that each point states, or where none is known over the
/// one measured, with the normal distribution.
ReportDrawing residual_histogram(const std::vector<const FormFigures*>& forms);

/// A characteristic at every position as dots, beside what is expected of it (NaN: not known) and
/// between the lines of what is permitted (above zero alone where no value is negative).
ReportDrawing by_position(const std::string& caption, const std::string& label,
                          const std::vector<double>& measured_mm,
                          const std::vector<double>& expected_mm, std::optional<double> mpe_mm);

/// What noise the points of each fit show, beside what they predict.
ReportTable noise_table(const std::vector<std::string>& names,
                        const std::vector<const FormFigures*>& forms);

/// Where the artefact stood: two drawings of positions in mm, x over y and x over z.
std::vector<ReportBlock> places_in_volume(const std::vector<Eigen::Vector3d>& places);

}  // namespace stria
