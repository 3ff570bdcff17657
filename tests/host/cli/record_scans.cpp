#include <cstdio>
#include <exception>
#include <filesystem>

#include "host/io/image_io.h"
#include "host/io/mesh_io.h"
#include "host/io/whole_file.h"
#include "host/local/open_device.h"
#include "tests/support/machine_scenes.h"
#include "tests/support/measured_object.h"

/// Records sweeps of a simulated swept scanner over a board and over the measured object, and
/// leaves nothing but the recordings: record_scans FOLDER.
namespace stria {
namespace {

namespace fs = std::filesystem;
using test_support::MachineScenes;

void record(const fs::path& scene, const ScanPlan& plan, std::size_t views, const fs::path& out) {
    OpenOptions options;
    options.seed = 21;
    options.threads = 2;
    const auto device = open_device("sim:" + scene.string(), options);
    fs::create_directories(out);
    for (std::size_t view = 0; view < views; ++view) {
        device->set_feature("SceneView", FeatureValue(static_cast<std::int64_t>(view)));
        RunOptions run;
        run.recording_path = (out / (std::to_string(view) + ".stria")).string();
        run.load.on_frame = [](const Frame&) {};
        device->run(plan, run);
    }
}

void record_all(const fs::path& folder) {
    fs::remove_all(folder);
    const fs::path scenes = folder / "scenes";
    fs::create_directories(scenes);
    const MachineScenes machine = test_support::machine_scenes(MachineKind::swept, 6);
    write_png((scenes / "board.png").string(), *machine.board_scene.objects.front().texture_image);
    write_whole_file((scenes / "board.toml").string(), format_scene(machine.board_scene));
    record(scenes / "board.toml", machine.board_plan, machine.board_scene.views.size(),
           folder / "board");

    Scene scene = machine.sphere_scene;
    SceneObject object;
    object.name = "object";
    object.shape = SceneShape::mesh;
    object.file = "object.ply";
    object.albedo = 0.8;
    object.mesh = std::make_shared<const TriMesh>(test_support::measured_object());
    write_mesh((scenes / object.file).string(), *object.mesh);
    scene.objects = {object};
    for (const Rigid3& pose : test_support::measured_object_poses())
        scene.views.push_back({"", {{"object", pose}}, {}});
    write_whole_file((scenes / "object.toml").string(), format_scene(scene));
    record(scenes / "object.toml", machine.sphere_plan, scene.views.size(), folder / "object");
    fs::remove_all(scenes);
}

}  // namespace
}  // namespace stria

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: record_scans FOLDER\n");
        return 2;
    }
    try {
        stria::record_all(argv[1]);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "record_scans: %s\n", error.what());
        return 1;
    }
    return 0;
}
