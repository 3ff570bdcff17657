// What the judging of pulses makes of scenes with reflected light: ghost_pictures FOLDER writes a
// PNG of each, one pixel a cell. White: right; yellow: flagged; red: wrong and not flagged; grey:
// lit, but no point; black: not lit.
#include <cstdio>
#include <string>

#include "host/io/image_io.h"
#include "tests/bench/picture_files.h"
#include "tests/host/scan/ghost_trials.h"

namespace stria {
namespace {

void draw(const std::string& file, const Scene& scene) {
    const test::GhostScan scan = test::scan_ghosts(scene, 1);
    write_png(file, test::picture_of(scan));
    std::printf("%s: right pulse chosen %.4f, without a warning %.4f, wrong %zu of %zu points\n",
                file.c_str(), scan.count.chosen_share(), scan.count.right_share(), scan.count.wrong,
                scan.count.points);
}

void draw_all(const std::string& folder) {
    draw(folder + "/groove_80.png", test::groove_scene({}));
    draw(folder + "/mirror.png", test::mirror_scene({}, {.width = 560, .height = 300}));
    draw(folder + "/plain.png", test::plain_scene(400, 320));
}

}  // namespace
}  // namespace stria

int main(int argc, char** argv) {
    return stria::test::draw_into_folder(argc, argv, stria::draw_all);
}
