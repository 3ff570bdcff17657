#include <algorithm>
#include <stdexcept>

#include "host/io/ply_writer.h"
#include "host/io/range_io.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

void put_point(LittleEndianBytes& out, const RangePoint& p, unsigned return_index,
               const float* sensitivity, int terms) {
    for (int i = 0; i < 3; ++i) out.put_float(p.position[i]);
    for (int i = 0; i < 3; ++i) out.put(p.normal[i]);
    out.put(p.intensity);
    out.put(p.sigma_mm);
    out.put(p.sigma_across_mm);
    out.put(p.sigma_systematic_mm);
    for (int i = 0; i < 3; ++i) out.put(p.error_direction[i]);
    out.put_float(p.s);
    for (int k = 0; k < terms; ++k) out.put(sensitivity ? sensitivity[k] : 0.0F);
    out.put(static_cast<std::uint8_t>(return_index));
    out.put(p.flags);
}

std::string format_header(const RangeImage& image, std::size_t vertices) {
    std::string text = "ply\nformat binary_little_endian 1.0\n";
    text += "obj_info num_cols " + std::to_string(image.width) + "\n";
    text += "obj_info num_rows " + std::to_string(image.height) + "\n";
    text += std::string("obj_info kind ") + name_of(image.kind) + "\n";
    if (!image.model_hash.empty()) text += "obj_info model_hash " + image.model_hash + "\n";
    text += "obj_info stria_version " STRIA_VERSION "\n";
    text += "element vertex " + std::to_string(vertices) + "\n";
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "intensity", "sigma", "sigma_across",
                             "sigma_systematic", "ex", "ey", "ez", "s"})
        text += std::string("property float ") + name + "\n";
    for (int k = 0; k < image.sensitivity_count; ++k)
        text += "property float sensitivity_" + std::to_string(k) + "\n";
    text += "property uchar return_index\nproperty ushort flags\n";
    text += "element range_grid " + std::to_string(image.cell_count()) +
            "\nproperty list uchar int vertex_indices\n";
    if (!image.stations.empty()) {
        text += "element station " + std::to_string(image.stations.size()) + "\n";
        for (const char* name : {"s", "cx", "cy", "cz", "lx", "ly", "lz"})
            text += std::string("property double ") + name + "\n";
    }
    return text + "end_header\n";
}

}  // namespace

std::string format_range_image(const RangeImage& image) {
    std::vector<const FurtherReturn*> further;
    for (const FurtherReturn& extra : image.further) further.push_back(&extra);
    std::stable_sort(further.begin(), further.end(),
                     [](const auto* a, const auto* b) { return a->cell < b->cell; });
    const std::size_t main = valid_count(image);
    std::string bytes = format_header(image, main + further.size());
    bytes.reserve(bytes.size() + (main + further.size()) * 64 + image.cell_count() * 5);
    LittleEndianBytes out(bytes);
    const auto terms = static_cast<std::size_t>(image.sensitivity_count);
    std::vector<std::int32_t> index_of(image.cell_count(), -1);
    std::int32_t next = 0;
    std::size_t extra = 0;
    for (std::size_t cell = 0; cell < image.cell_count(); ++cell) {
        if (image.mask[cell] == 0) continue;
        index_of[cell] = next++;
        put_point(out, image.points[cell], 0,
                  terms ? image.sensitivity.data() + cell * terms : nullptr,
                  image.sensitivity_count);
        for (; extra < further.size() && further[extra]->cell == cell; ++extra, ++next)
            put_point(out, further[extra]->point, further[extra]->return_index, nullptr,
                      image.sensitivity_count);
    }
    if (extra != further.size())
        throw std::invalid_argument("write_range_image: a further return's cell " +
                                    std::to_string(further[extra]->cell) + " has no point");
    for (const std::int32_t index : index_of) {
        out.put(static_cast<std::uint8_t>(index >= 0 ? 1 : 0));
        if (index >= 0) out.put(index);
    }
    for (const Station& station : image.stations) {
        out.put(station.s);
        for (int i = 0; i < 3; ++i) out.put(station.camera_in_scan[i]);
        for (int i = 0; i < 3; ++i) out.put(station.laser_in_scan[i]);
    }
    return bytes;
}

void write_range_image(const std::string& path, const RangeImage& image) {
    write_whole_file(path, format_range_image(image));
}

}  // namespace stria
