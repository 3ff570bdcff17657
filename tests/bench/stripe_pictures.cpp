// Pictures of what spacetime analysis is for: stripe_pictures FOLDER writes one SVG a case with the
// true surface and the points that spatial peaks and spacetime pulses make of it, in closed-form
// light (tests/firmware/stripe/lit_profile.h).
#include <cmath>
#include <string>
#include <vector>

#include "tests/bench/picture_files.h"
#include "tests/firmware/stripe/lit_profile.h"

namespace stria {
namespace {

constexpr double kFootprint = 0.13;  // sigma_p over sigma_b

PlotSeries surface_of(const test::LitProfile& p) {
    PlotSeries line{.name = "surface", .x = {}, .y = {}};
    for (const test::ProfileSegment& s : p.segments) {
        for (const double x : {s.x0, s.x1}) {
            line.x.push_back(x / p.beam_width);
            line.y.push_back(s.height_at(x) / p.beam_width);
        }
        line.x.push_back(NAN);  // a gap between the segments
        line.y.push_back(NAN);
    }
    return line;
}

PlotSeries dots(const std::string& name, const test::LitProfile& p,
                const std::vector<test::ProfilePoint>& points) {
    PlotSeries series{.name = name, .x = {}, .y = {}, .points = true};
    for (const test::ProfilePoint& at : points) {
        series.x.push_back(at.x / p.beam_width);
        series.y.push_back(at.z / p.beam_width);
    }
    return series;
}

void draw(const std::string& file, const test::LitProfile& p) {
    const test::ProfileSweep sweep(p);
    LinePlot plot{.x = {"along the sweep", "sigma_b"}, .y = {"height", "sigma_b"}, .series = {}};
    plot.series = {surface_of(p), dots("spatial, centre of gravity", p, sweep.spatial_peaks(2)),
                   dots("spacetime", p, sweep.spacetime_pulses())};
    test::write_plot(file, plot);
}

void draw_all(const std::string& folder) {
    for (const double degrees : {150.0, 120.0, 90.0}) {
        test::LitProfile p = test::corner_profile(degrees, true, kFootprint);
        for (test::ProfileSegment& s : p.segments) {  // as far as the sweep goes
            (s.x0 < 0 ? s.z0 : s.z1) *= p.reach / 90;
            (s.x0 < 0 ? s.x0 : s.x1) *= p.reach / 90;
        }
        draw(folder + "/corner_" + std::to_string(std::lround(degrees)) + ".svg", p);
    }
    draw(folder + "/strip.svg", test::strip_profile(kFootprint));
}

}  // namespace
}  // namespace stria

int main(int argc, char** argv) {
    return stria::test::draw_into_folder(argc, argv, stria::draw_all);
}
