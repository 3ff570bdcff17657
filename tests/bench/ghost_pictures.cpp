// What the judging of pulses makes of scenes with reflected light: ghost_pictures FOLDER writes a
// PNG of each, one pixel a cell. White: right; yellow: flagged; red: wrong and not flagged; grey:
// lit, but no point; black: not lit.
#include <cstdio>
#include <filesystem>
#include <string>

#include "host/io/image_io.h"
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

}  // namespace
}  // namespace stria

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: ghost_pictures FOLDER\n");
        return 2;
    }
    const std::string folder = argv[1];
    std::filesystem::create_directories(folder);
    stria::draw(folder + "/groove_80.png", stria::test::groove_scene(80, 0.9, 800, 200));
    stria::draw(folder + "/mirror.png", stria::test::mirror_scene(560, 300));
    stria::draw(folder + "/plain.png", stria::test::plain_scene(400, 320));
    return 0;
}
