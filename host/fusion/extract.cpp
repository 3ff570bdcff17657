#include "host/fusion/extract.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "host/fusion/brick_window.h"
#include "host/fusion/cube_cases.h"
#include "host/fusion/finish_surface.h"
#include "host/fusion/tidy_border.h"
#include "host/geometry/parallel.h"

namespace stria {
namespace {

using Eigen::Vector3i;

constexpr std::uint32_t kEdges = 3 * kBrickVoxels;  ///< edges a brick owns: three a voxel
constexpr std::uint32_t kWords = kEdges / 32;

/// A crossed edge of the voxel lattice: number of the owning brick << 11 | axis << 9 | voxel.
using EdgeKey = std::uint64_t;

/// Bricks whose cells the surface may cross, ascending in z, y, x.
class ActiveBricks {
  public:
    ActiveBricks(const SdfVolume& volume, const WindowReader& reader, bool fill) {
        if (fill)
            find_fronts(volume, reader);
        else
            for (const Brick& brick : volume.bricks())
                if (brick.sums) at_.push_back(brick.at);
        std::sort(at_.begin(), at_.end(),
                  [](const Vector3i& a, const Vector3i& b) { return brick_key(a) < brick_key(b); });
        for (std::uint32_t i = 0; i < at_.size(); ++i) number_.emplace(brick_key(at_[i]), i);
    }

    std::size_t size() const { return at_.size(); }
    const Vector3i& at(std::size_t number) const { return at_[number]; }
    /// Numbers of the brick's neighbours at +x, +y, +z and so on by bits; those missing keep 0,
    /// as no crossed edge of a cell here is theirs.
    std::array<std::uint32_t, 8> neighbours(std::size_t number) const {
        std::array<std::uint32_t, 8> found{};
        for (int part = 0; part < 8; ++part) {
            const Vector3i step(part & 1, part >> 1 & 1, part >> 2 & 1);
            const auto entry = number_.find(brick_key(at_[number] + step));
            if (entry != number_.end()) found[static_cast<std::size_t>(part)] = entry->second;
        }
        return found;
    }

  private:
    /// Every brick that is not, with its seven neighbours, one uniform state.
    void find_fronts(const SdfVolume& volume, const WindowReader& reader) {
        const CarvedBox& box = volume.carved();
        std::vector<VoxelState> states(box.all_empty.size());
        const auto layer =
            static_cast<std::size_t>(box.size.x()) * static_cast<std::size_t>(box.size.y());
        const auto place = [&](std::size_t i) {
            const auto width = static_cast<std::size_t>(box.size.x());
            return Vector3i(box.min + Vector3i(static_cast<int>(i % width),
                                               static_cast<int>(i % layer / width),
                                               static_cast<int>(i / layer)));
        };
        parallel_for_blocks(states.size(), 4096, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) states[i] = reader.uniform_state(place(i));
        });
        for (std::size_t i = 0; i < states.size(); ++i) {
            const Vector3i at = place(i);
            bool same = states[i] != VoxelState::near_surface;
            for (int part = 1; part < 8 && same; ++part) {
                const Vector3i other = at + Vector3i(part & 1, part >> 1 & 1, part >> 2 & 1);
                const VoxelState state =
                    box.contains(other) ? states[box.index(other)] : VoxelState::empty;
                same = state == states[i];
            }
            if (!same) at_.push_back(at);
        }
    }

    std::vector<Vector3i> at_;
    std::unordered_map<std::uint64_t, std::uint32_t> number_;
};

/// What one brick contributes.
struct BrickSurface {
    std::vector<std::array<EdgeKey, 3>> triangles;
    std::array<std::uint32_t, kWords> used{};    ///< one bit an owned edge
    std::array<std::uint16_t, kWords> before{};  ///< used edges in earlier words
    std::size_t first_vertex = 0;
};

class Extractor {
  public:
    Extractor(const SdfVolume& volume, const ClosingBody& body, bool fill)
        : volume_(volume),
          reader_(volume, body, fill),
          fill_(fill),
          bricks_(volume, reader_, fill),
          surfaces_(bricks_.size()) {}

    TriMesh run() {
        for_each_brick([this](std::size_t i, const BrickWindow& w) { find_triangles(i, w); });
        const std::size_t vertices = number_vertices();
        TriMesh mesh;
        mesh.positions.resize(vertices);
        mesh.attributes.push_back({"filled", 1, std::vector<float>(vertices, 0)});
        mesh.attributes.push_back({"sigma", 1, std::vector<float>(vertices, 0)});
        for_each_brick([&](std::size_t i, const BrickWindow& w) { place_vertices(i, w, mesh); });
        collect_triangles(mesh);
        return mesh;
    }

  private:
    template <typename Body>
    void for_each_brick(const Body& body) {
        parallel_for_blocks(bricks_.size(), 16, [&](std::size_t begin, std::size_t end) {
            auto window = std::make_unique<BrickWindow>();
            for (std::size_t i = begin; i < end; ++i) {
                reader_.read(bricks_.at(i), *window);
                body(i, *window);
            }
        });
    }

    void find_triangles(std::size_t number, const BrickWindow& window) {
        std::array<std::uint32_t, 8> owners{};
        bool owners_known = false;
        for (int z = 0; z < kBrickSide; ++z)
            for (int y = 0; y < kBrickSide; ++y)
                for (int x = 0; x < kBrickSide; ++x) {
                    const unsigned inside = cell_case(window, BrickWindow::index(x, y, z));
                    if (inside == 0) continue;
                    if (!owners_known) owners = bricks_.neighbours(number);
                    owners_known = true;
                    for (const auto& t : cube_cases().triangles[inside])
                        surfaces_[number].triangles.push_back({use_edge(x, y, z, t[0], owners),
                                                               use_edge(x, y, z, t[1], owners),
                                                               use_edge(x, y, z, t[2], owners)});
                }
    }

    /// Which corners of a cell are inside; 0 where the surface does not cross the cell or where too
    /// little is known: every crossed edge must have both ends measured, unless holes are filled.
    unsigned cell_case(const BrickWindow& window, std::size_t at) const {
        unsigned inside = 0, near = 0;
        for (std::size_t c = 0; c < 8; ++c) {
            inside |= unsigned{window.value[at + corner_step_[c]] < 0} << c;
            near |= unsigned{window.state[at + corner_step_[c]] == VoxelState::near_surface} << c;
        }
        if (inside == 0 || inside == 255) return 0;
        if (fill_ || near == 255) return inside;
        for (unsigned c = 0; c < 8; ++c) {
            if (near >> c & 1) continue;
            if (!window.side_known[at + corner_step_[c]]) return 0;
            for (unsigned axis = 0; axis < 3; ++axis)
                if ((inside >> c ^ inside >> (c ^ 1u << axis)) & 1) return 0;
        }
        return inside;
    }

    EdgeKey use_edge(int x, int y, int z, std::uint8_t cube_edge,
                     const std::array<std::uint32_t, 8>& owners) {
        const CubeEdge edge = cube_cases().edges[cube_edge];
        const int ex = x + (edge.low & 1), ey = y + (edge.low >> 1 & 1), ez = z + (edge.low >> 2);
        const auto part = static_cast<std::size_t>((ex >> 3) | (ey >> 3) << 1 | (ez >> 3) << 2);
        const auto local = static_cast<std::uint32_t>(edge.axis) << 9 |
                           static_cast<std::uint32_t>(voxel_index(ex & 7, ey & 7, ez & 7));
        std::atomic_ref<std::uint32_t>(surfaces_[owners[part]].used[local / 32])
            .fetch_or(1u << (local % 32), std::memory_order_relaxed);
        return static_cast<EdgeKey>(owners[part]) << 11 | local;
    }

    std::size_t number_vertices() {
        std::size_t count = 0;
        for (BrickSurface& surface : surfaces_) {
            surface.first_vertex = count;
            std::uint16_t here = 0;
            for (std::size_t w = 0; w < kWords; ++w) {
                surface.before[w] = here;
                here = static_cast<std::uint16_t>(here + std::popcount(surface.used[w]));
            }
            count += here;
        }
        return count;
    }

    std::uint32_t vertex_number(EdgeKey key) const {
        const BrickSurface& surface = surfaces_[key >> 11];
        const auto local = static_cast<std::uint32_t>(key & 2047);
        const std::uint32_t lower = surface.used[local / 32] & ((1u << (local % 32)) - 1);
        return static_cast<std::uint32_t>(surface.first_vertex + surface.before[local / 32] +
                                          static_cast<unsigned>(std::popcount(lower)));
    }

    void place_vertices(std::size_t number, const BrickWindow& window, TriMesh& mesh) {
        const BrickSurface& surface = surfaces_[number];
        for (std::uint32_t local = 0; local < kEdges; ++local) {
            if (!(surface.used[local / 32] >> (local % 32) & 1)) continue;
            const int axis = static_cast<int>(local >> 9);
            const Vector3i low(static_cast<int>(local & 7), static_cast<int>(local >> 3 & 7),
                               static_cast<int>(local >> 6 & 7));
            const std::size_t a = BrickWindow::index(low.x(), low.y(), low.z());
            const std::size_t b = a + corner_step_[std::size_t{1} << axis];
            const double va = static_cast<double>(window.value[a]);
            const double vb = static_cast<double>(window.value[b]);
            // Not onto a corner, where several vertices of a cell would fall together.
            const double t = std::clamp(va / (va - vb), 1e-3, 1 - 1e-3);
            Eigen::Vector3d place = (kBrickSide * bricks_.at(number) + low).cast<double>();
            place[axis] += t;
            const std::uint32_t v = vertex_number(static_cast<EdgeKey>(number) << 11 | local);
            mesh.positions[v] = volume_.voxel_mm() * place;
            const bool measured = window.state[a] == VoxelState::near_surface &&
                                  window.state[b] == VoxelState::near_surface;
            mesh.attributes[0].values[v] = measured ? 0.0f : 1.0f;
            if (measured)
                mesh.attributes[1].values[v] =
                    static_cast<float>((1 - t) * static_cast<double>(window.sigma_mm[a]) +
                                       t * static_cast<double>(window.sigma_mm[b]));
        }
    }

    void collect_triangles(TriMesh& mesh) {
        std::vector<std::size_t> first(surfaces_.size() + 1, 0);
        for (std::size_t i = 0; i < surfaces_.size(); ++i)
            first[i + 1] = first[i] + surfaces_[i].triangles.size();
        mesh.triangles.resize(first.back());
        parallel_for_blocks(surfaces_.size(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                for (std::size_t k = 0; k < surfaces_[i].triangles.size(); ++k)
                    for (std::size_t c = 0; c < 3; ++c)
                        mesh.triangles[first[i] + k][c] =
                            vertex_number(surfaces_[i].triangles[k][c]);
        });
    }

    static std::array<std::size_t, 8> corner_steps() {
        std::array<std::size_t, 8> steps;
        for (int c = 0; c < 8; ++c)
            steps[static_cast<std::size_t>(c)] =
                BrickWindow::index(c & 1, c >> 1 & 1, c >> 2) - BrickWindow::index(0, 0, 0);
        return steps;
    }

    const SdfVolume& volume_;
    WindowReader reader_;
    bool fill_;
    std::array<std::size_t, 8> corner_step_ = corner_steps();
    ActiveBricks bricks_;
    std::vector<BrickSurface> surfaces_;
};

bool has_sigmas(const SdfVolume& volume) {
    return std::any_of(volume.bricks().begin(), volume.bricks().end(),
                       [](const Brick& brick) { return brick.sigmas != nullptr; });
}

}  // namespace

TriMesh extract_surface(const SdfVolume& volume, const ClosingBody& body,
                        const ExtractOptions& options) {
    TriMesh mesh = Extractor(volume, body, options.fill_holes).run();
    if (!has_sigmas(volume)) mesh.attributes.pop_back();
    const double h = volume.voxel_mm();
    if (!options.fill_holes) tidy_border(mesh, 2 * h, options.border_rounds);
    drop_small_components(mesh, options.min_component_voxels2 * h * h);
    if (options.fill_holes) smooth_filled(mesh, options.fill_smoothing_rounds);
    add_normals(mesh);
    return mesh;
}

}  // namespace stria
