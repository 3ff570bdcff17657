#include "host/io/range_io.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/core/errors.h"
#include "host/io/number_text.h"
#include "host/io/ply_file.h"
#include "host/io/text_lines.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

constexpr std::uint32_t kNoCell = std::numeric_limits<std::uint32_t>::max();

/// Rows of a table's columns by name; missing columns read as 0.
class Rows {
  public:
    explicit Rows(const PlyTable& table) : table_(table) {}
    const PlyColumn* column(const std::string& name) const { return table_.scalars(name); }
    const PlyColumn* required(const std::string& name, const std::string& file) const {
        if (const PlyColumn* found = column(name)) return found;
        throw FileError(file, "element " + table_.element.name,
                        "expected property '" + name + "', found none");
    }

  private:
    const PlyTable& table_;
};

double value(const PlyColumn* column, std::size_t row) { return column ? column->values[row] : 0; }

/// Clamped to T's range; NaN becomes 0.
template <typename T>
T whole(const PlyColumn* column, std::size_t row) {
    const double v = value(column, row);
    if (!(v > 0)) return 0;
    return static_cast<T>(std::min(v, static_cast<double>(std::numeric_limits<T>::max())));
}

/// The vertex columns that make a RangePoint.
struct PointColumns {
    std::array<const PlyColumn*, 3> position, normal, error;
    const PlyColumn *intensity, *sigma, *sigma_across, *sigma_systematic, *s, *flags;
    std::vector<const PlyColumn*> sensitivity;
    double mm_per_unit;

    PointColumns(const PlyTable& table, const std::string& file, double scale)
        : mm_per_unit(scale) {
        const Rows rows(table);
        position = {rows.required("x", file), rows.required("y", file), rows.required("z", file)};
        normal = {rows.column("nx"), rows.column("ny"), rows.column("nz")};
        error = {rows.column("ex"), rows.column("ey"), rows.column("ez")};
        intensity = rows.column("intensity");
        sigma = rows.column("sigma");
        sigma_across = rows.column("sigma_across");
        sigma_systematic = rows.column("sigma_systematic");
        s = rows.column("s");
        flags = rows.column("flags");
        for (int k = 0;; ++k) {
            const PlyColumn* next = rows.column("sensitivity_" + std::to_string(k));
            if (!next) break;
            sensitivity.push_back(next);
        }
    }

    RangePoint point(std::size_t row) const {
        const auto length = [&](const PlyColumn* c) {
            return static_cast<float>(mm_per_unit * value(c, row));
        };
        RangePoint p;
        for (std::size_t i = 0; i < 3; ++i) {
            const auto k = static_cast<Eigen::Index>(i);
            p.position[k] = mm_per_unit * value(position[i], row);
            p.normal[k] = static_cast<float>(value(normal[i], row));
            p.error_direction[k] = static_cast<float>(value(error[i], row));
        }
        p.intensity = static_cast<float>(value(intensity, row));
        p.sigma_mm = length(sigma);
        p.sigma_across_mm = length(sigma_across);
        p.sigma_systematic_mm = length(sigma_systematic);
        p.s = value(s, row);
        p.flags = whole<std::uint16_t>(flags, row);
        return p;
    }
};

int side_of(const PlyHeader& header, const std::string& key, const std::string& file) {
    const std::string text = header.info(key);
    const auto number = parse_integer(std::string_view(text).substr(0, text.find(' ')));
    if (!number || *number < 0 || *number > 1'000'000)
        throw FileError(file, "header",
                        "expected 'obj_info " + key +
                            " N' with N up to 1000000, "
                            "found '" +
                            shown(text) + "'");
    return static_cast<int>(*number);
}

const PlyColumn& grid_lists(const PlyTable& grid, const std::string& file) {
    for (const char* name : {"vertex_indices", "vertex_index"})
        if (const PlyColumn* lists = grid.lists(name)) return *lists;
    throw FileError(file, "element range_grid",
                    "expected 'property list uchar int vertex_indices', found none");
}

RangePoint checked_point(const PointColumns& columns, std::size_t row, const std::string& file) {
    RangePoint point = columns.point(row);
    if (!point.position.allFinite())
        throw FileError(file, "element vertex, row " + std::to_string(row),
                        "expected finite coordinates");
    return point;
}

/// Fills the cells from the grid's lists; returns each vertex's cell, kNoCell where it has none.
std::vector<std::uint32_t> fill_cells(RangeImage& image, const PlyTable& grid,
                                      const PointColumns& columns, std::size_t vertices,
                                      const std::string& file) {
    const PlyColumn& lists = grid_lists(grid, file);
    std::vector<std::uint32_t> cell_of(vertices, kNoCell);
    const std::size_t terms = columns.sensitivity.size();
    image.sensitivity_count = static_cast<int>(terms);
    image.sensitivity.assign(terms * image.cell_count(), 0.0F);
    for (std::size_t cell = 0; cell < image.cell_count(); ++cell) {
        const std::size_t count = lists.begin[cell + 1] - lists.begin[cell];
        const std::string place = "element range_grid, row " + std::to_string(cell);
        if (count == 0) continue;
        if (count > 1)
            throw FileError(file, place,
                            "expected a list of 0 or 1 index, found " + std::to_string(count));
        const double index = lists.values[lists.begin[cell]];
        if (!(index >= 0 && index < static_cast<double>(vertices)) || index != std::floor(index))
            throw FileError(file, place,
                            "expected a vertex index below " + std::to_string(vertices) +
                                ", found " + std::to_string(index));
        const auto row = static_cast<std::size_t>(index);
        image.points[cell] = checked_point(columns, row, file);
        image.mask[cell] = 1;
        cell_of[row] = static_cast<std::uint32_t>(cell);
        for (std::size_t k = 0; k < terms; ++k)
            image.sensitivity[cell * terms + k] =
                static_cast<float>(columns.mm_per_unit * columns.sensitivity[k]->values[row]);
    }
    return cell_of;
}

/// Vertices with a return_index above 0 belong to the cell of the last vertex before them that has
/// one.
void add_further_returns(RangeImage& image, const PlyTable& vertex, const PointColumns& columns,
                         const std::vector<std::uint32_t>& cell_of, const std::string& file) {
    const PlyColumn* return_index = vertex.scalars("return_index");
    if (!return_index) return;
    std::uint32_t cell = kNoCell;
    for (std::size_t row = 0; row < cell_of.size(); ++row) {
        if (cell_of[row] != kNoCell) cell = cell_of[row];
        const auto index = whole<std::uint8_t>(return_index, row);
        if (index == 0 || cell_of[row] != kNoCell) continue;
        if (cell == kNoCell)
            throw FileError(file, "element vertex, row " + std::to_string(row),
                            "a further return stands before any cell's first one");
        image.further.push_back({cell, index, checked_point(columns, row, file)});
    }
}

void read_stations(RangeImage& image, const PlyFile& ply, double mm_per_unit,
                   const std::string& file) {
    const PlyTable* table = ply.find("station");
    if (!table) return;
    const Rows rows(*table);
    std::array<const PlyColumn*, 7> columns{};
    const char* const kNames[7] = {"s", "cx", "cy", "cz", "lx", "ly", "lz"};
    for (std::size_t i = 0; i < 7; ++i) columns[i] = rows.required(kNames[i], file);
    for (std::size_t row = 0; row < table->element.count; ++row) {
        const auto at = [&](std::size_t c) { return columns[c]->values[row]; };
        Station station{at(0), mm_per_unit * Eigen::Vector3d(at(1), at(2), at(3)),
                        mm_per_unit * Eigen::Vector3d(at(4), at(5), at(6))};
        const bool ascends = row == 0 || station.s > image.stations.back().s;
        if (!std::isfinite(station.s) || !station.camera_in_scan.allFinite() ||
            !station.laser_in_scan.allFinite() || !ascends)
            throw FileError(file, "element station, row " + std::to_string(row),
                            "expected finite numbers and s above that of the row before");
        image.stations.push_back(station);
    }
}

}  // namespace

RangeImage parse_range_image(std::string_view bytes, const std::string& name, double mm_per_unit) {
    const PlyFile ply = parse_ply(bytes, name);
    const PlyTable* vertex = ply.find("vertex");
    const PlyTable* grid = ply.find("range_grid");
    if (!vertex || !grid)
        throw FileError(name, "header",
                        std::string("expected a range image with element ") +
                            (vertex ? "range_grid" : "vertex") + ", found none");
    const int width = side_of(ply.header, "num_cols", name);
    const int height = side_of(ply.header, "num_rows", name);
    const auto cells = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    if (cells != grid->element.count || cells >= kNoCell)
        throw FileError(name, "header",
                        "expected num_cols x num_rows = " + std::to_string(cells) +
                            " rows of range_grid, found " + std::to_string(grid->element.count));
    const PointColumns columns(*vertex, name, mm_per_unit);
    grid_lists(*grid, name);
    RangeImage image = make_range_image(width, height);
    if (const std::string kind = ply.header.info("kind"); !kind.empty()) {
        const auto machine = machine_kind_from(kind);
        if (!machine)
            throw FileError(name, "header",
                            "expected obj_info kind swept, rail or turntable, "
                            "found '" +
                                shown(kind) + "'");
        image.kind = *machine;
    }
    image.model_hash = ply.header.info("model_hash");
    const auto cell_of = fill_cells(image, *grid, columns, vertex->element.count, name);
    add_further_returns(image, *vertex, columns, cell_of, name);
    read_stations(image, ply, mm_per_unit, name);
    return image;
}

RangeImage read_range_image(const std::string& path, double mm_per_unit) {
    return parse_range_image(read_whole_file(path), path, mm_per_unit);
}

bool has_range_grid(const std::string& path) {
    std::string start = read_file_start(path, 65536);
    if (start.size() == 65536 && start.find("end_header") == std::string::npos)
        start = read_whole_file(path);
    return parse_ply_header(start, path).find("range_grid") != nullptr;
}

}  // namespace stria
