// Writes the seeds of the fuzz corpora: small files of every kind, each made by our own or the
// format's own writer. What fuzzing found since stands beside them and stays.
//   write_fuzz_corpus tests/fuzz/corpus
#include <cstdio>
#include <filesystem>
#include <string>

#include "firmware/core/scan_plan.h"
#include "host/cli/scan_notes.h"
#include "host/io/certificate.h"
#include "host/io/image_io.h"
#include "host/io/mesh_formats.h"
#include "host/io/model_io.h"
#include "host/io/range_io.h"
#include "sim/scene.h"
#include "tests/fuzz/write_seed.h"
#include "tests/host/io/encoded_images.h"

namespace stria {
namespace {

void write_images(const std::filesystem::path& folder) {
    Image<std::uint8_t> grey(9, 5), colour(6, 4, 3);
    Image<std::uint16_t> deep(5, 3);
    for (std::size_t i = 0; i < grey.values.size(); ++i)
        grey.values[i] = static_cast<std::uint8_t>(i * 5);
    for (std::size_t i = 0; i < colour.values.size(); ++i) {
        colour.values[i] = static_cast<std::uint8_t>(i * 3);
    }
    for (std::size_t i = 0; i < deep.values.size(); ++i) {
        deep.values[i] = static_cast<std::uint16_t>(i * 4000);
    }
    write_seed(folder / "grey.png", encode_png(grey));
    write_seed(folder / "colour.png", encode_png(colour));
    write_seed(folder / "deep.png", encode_png(deep));
    write_seed(folder / "grey.jpg", encode_jpeg(grey, 80));
    write_seed(folder / "colour.jpg", encode_jpeg(colour, 50));
    write_seed(folder / "grey.tif", encode_tiff(grey, 1));      // uncompressed
    write_seed(folder / "colour.tif", encode_tiff(colour, 5));  // LZW
    write_seed(folder / "deep.tif", encode_tiff(deep, 8));      // deflate
}

void write_models(const std::filesystem::path& folder) {
    const CameraModel camera{LensKind::brown5,    640, 480, 800, 801, 319.5, 239.5,
                             {0.1, -0.2, 0, 0, 0}};
    write_seed(folder / "camera", "c" + format_camera(camera));
    ScannerModel scanner;
    Channel channel;
    channel.camera = camera;
    scanner.channels.push_back(channel);
    write_seed(folder / "scanner", "s" + format_scanner(scanner));
    Certificate certificate;
    certificate.temperature_c = 21;
    write_seed(folder / "certificate", "k" + format_certificate(certificate));
    write_seed(folder / "sphere_artefact",
               "akind = \"sphere\"\ndiameter_mm = 30\ndiameter_u_mm = 0.001\n"
               "[temperature]\nmeasured_c = 22\nmeasured_u_c = 1\ncte_per_k = 1e-5\n"
               "cte_u_per_k = 1e-6\n[mpe]\nsize_mm = 0.1\n");
    write_seed(folder / "beam_artefact",
               "akind = \"beam\"\ndiameters_mm = [20, 20, 20]\ndiameters_u_mm = [0, 0, 0]\n"
               "lengths_mm = [50, 100]\nlengths_u_mm = [0, 0]\n");
    ScanNotes notes;
    notes.temperature_c = 21;
    write_seed(folder / "scan", "n" + format_scan_notes(notes));
    notes.check = ShapeCheck{"plane", shape_figures("plane"), Eigen::Matrix3d::Identity(),
                             Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero()};
    write_seed(folder / "checked_scan", "n" + format_scan_notes(notes));
    ScanPlan plan;
    plan.to = 0.5;
    plan.step = 0.001;
    write_seed(folder / "plan", "l" + format_plan(plan));
    write_seed(folder / "poses",
               "p[[scan]]\nfile = \"a.ply\"\nfixed = true\nworld_from_scan = "
               "[1,0,0,0, 0,1,0,0, 0,0,1,5, 0,0,0,1]\n");
    write_seed(folder / "conf",
               "fcamera 0 0 0 0 0 0 1\nmesh a.ply\nbmesh b.ply 1 2 3 0 0.6 0 0.8\n");
    write_seed(folder / "matrix", "m1 0 0 0\n0 1 0 0\n0 0 1 5\n0 0 0 1\n");
}

void write_ranges(const std::filesystem::path& folder) {
    write_seed(folder / "stanford.ply",
               "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 2\n"
               "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
               "element range_grid 4\nproperty list uchar int vertex_indices\nend_header\n"
               "0 0 1\n1 0 1\n0 1 1.5\n1 0\n1 1\n1 2\n0\n");
    const RangeImage image = parse_range_image(
        "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 1\n"
        "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
        "element range_grid 2\nproperty list uchar int vertex_indices\n"
        "end_header\n0 0 1\n1 0 1\n1 0\n1 1\n",
        "seed");
    write_seed(folder / "binary.ply", format_range_image(image));
}

void write_meshes(const std::filesystem::path& folder) {
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    write_seed(folder / "binary.ply", "p" + format_ply(mesh.positions, mesh.triangles, {}, true));
    write_seed(folder / "ascii.ply",
               "pply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
               "property float z\nproperty uchar red\nelement face 1\n"
               "property list uchar int vertex_indices\nend_header\n"
               "0 0 0 1\n1 0 0 2\n1 1 0 3\n0 1 0 4\n4 0 1 2 3\n");
    write_seed(folder / "mesh.obj", "o" + format_obj(mesh));
    write_seed(folder / "relative.obj", "ov 0 0 0\nv 1 0 0\nv 0 1 0\nf -3/1/1 -2//1 -1\n");
    write_seed(folder / "mesh.stl", "s" + format_stl(mesh));
    write_seed(folder / "ascii.stl",
               "ssolid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
               "vertex 0 1 0\nendloop\nendfacet\nendsolid a\n");
    write_seed(folder / "mesh.off", "f" + format_off(mesh));
    PointCloud cloud;
    cloud.positions = mesh.positions;
    write_seed(folder / "points.ply", "y" + format_ply(cloud.positions, {}, {}, false));
    write_seed(folder / "points.pcd", "d" + format_pcd(cloud));
    write_seed(folder / "points.xyz", "x" + format_xyz(cloud, ' '));
    write_seed(folder / "points.csv", "x" + format_xyz(cloud, ','));
}

void write_scenes(const std::filesystem::path& folder) {
    write_seed(folder / "built_in.toml", format_scene(built_in_scene()));
}

}  // namespace
}  // namespace stria

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: write_fuzz_corpus FOLDER\n");
        return 2;
    }
    const std::filesystem::path corpus = argv[1];
    stria::write_wire_seeds(corpus);
    stria::write_sweep_seeds(corpus);
    stria::write_images(corpus / "fuzz_image");
    stria::write_models(corpus / "fuzz_model");
    stria::write_ranges(corpus / "fuzz_range_ply");
    stria::write_meshes(corpus / "fuzz_mesh");
    stria::write_scenes(corpus / "fuzz_scene");
    return 0;
}
