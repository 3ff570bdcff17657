// Pictures of spacetime analysis on rendered frames: rendered_pictures FOLDER writes one SVG a case
// with the true surface and the points that spatial peaks, spacetime pulses and these moved to
// their centres of light make of it (tests/host/cli/rendered_profile.h), and prints their files.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/bench/picture_files.h"
#include "tests/host/cli/rendered_profile.h"

namespace stria {
namespace {

using test_support::LocatedProfile;
using test_support::ProfilePoint;
using test_support::RenderedProfile;

constexpr double kFootprint = 0.13;  // sigma_p over sigma_b

PlotSeries surface_of(const RenderedProfile& profile, double reach) {
    PlotSeries line{.name = "surface", .x = {}, .y = {}};
    for (const test_support::SurfacePiece& piece : profile.pieces) {
        for (const double end : {piece.x0, piece.x1}) {
            const double x = std::clamp(end, -reach, reach);
            line.x.push_back(x);
            line.y.push_back(piece.height_at(x));
        }
        line.x.push_back(NAN);  // a gap between the pieces
        line.y.push_back(NAN);
    }
    return line;
}

PlotSeries dots(const std::string& name, const std::vector<ProfilePoint>& points, double reach) {
    PlotSeries series{.name = name, .x = {}, .y = {}, .points = true};
    for (const ProfilePoint& at : points) {
        if (std::abs(at.x) > reach) continue;
        series.x.push_back(at.x);
        series.y.push_back(at.z);
    }
    return series;
}

void draw(const std::string& file, const RenderedProfile& profile, int most_a_row, double reach) {
    const LocatedProfile at = located(profile, most_a_row);
    LinePlot plot{.x = {"along the sweep", "mm"}, .y = {"height", "mm"}, .series = {}};
    plot.series = {surface_of(profile, reach), dots("spatial, centre of gravity", at.peaks, reach),
                   dots("spacetime", at.pulses, reach),
                   dots("its centres of light", at.centred, reach)};
    test::write_plot(file, plot);
}

void draw_all(const std::string& folder) {
    draw(folder + "/rendered_card_1995.svg", test_support::rendered_card(10, 0.45, 0), 1, 3);
    for (const double degrees : {150.0, 120.0, 90.0})
        draw(folder + "/rendered_corner_" + std::to_string(std::lround(degrees)) + ".svg",
             test_support::rendered_corner(degrees, true, kFootprint), 1, 6);
    draw(folder + "/rendered_strip.svg", test_support::rendered_strip(kFootprint), 2, 10);
}

}  // namespace
}  // namespace stria

int main(int argc, char** argv) {
    return stria::test::draw_into_folder(argc, argv, stria::draw_all);
}
