#include "host/fusion/fuse.h"

#include <algorithm>
#include <ctime>
#include <stdexcept>

#include "firmware/core/median.h"
#include "host/core/errors.h"
#include "host/fusion/background.h"
#include "host/fusion/carve.h"
#include "host/fusion/extract.h"
#include "host/fusion/integrate.h"
#include "host/fusion/range_surface.h"
#include "host/geometry/range_grid.h"

namespace stria {
namespace {

double process_cpu_seconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Adds the CPU time of a scope to a sum.
class CpuTimer {
  public:
    explicit CpuTimer(double& sum) : sum_(sum), start_(process_cpu_seconds()) {}
    ~CpuTimer() { sum_ += process_cpu_seconds() - start_; }
    CpuTimer(const CpuTimer&) = delete;
    CpuTimer& operator=(const CpuTimer&) = delete;

  private:
    double& sum_;
    double start_;
};

double default_voxel_mm(const std::vector<FuseScan>& scans) {
    std::vector<double> pitches;
    for (const FuseScan& scan : scans)
        if (const double pitch = median_pitch_mm(*scan.image); pitch > 0) pitches.push_back(pitch);
    const double voxel = median(pitches);
    if (!(voxel > 0)) throw Error("fuse: no scan has two neighbouring points");
    return voxel;
}

/// Half the smallest median of the scans, so that the typical point keeps a quarter of the range
/// of weights above it; 0 unless every scan knows its sigmas.
double reference_sigma_mm(const std::vector<FuseScan>& scans) {
    double least = 1e300;
    for (const FuseScan& scan : scans) {
        const double sigma = median_sigma_mm(*scan.image);
        if (!(sigma > 0)) return 0;
        least = std::min(least, sigma);
    }
    return least / 2;
}

void carve_scans(FusedVolume& fused, const std::vector<FuseScan>& scans,
                 const RangeSurfaceOptions& surface_options, const FuseOptions& options,
                 std::size_t max_bytes) {
    const CpuTimer timer(fused.cpu_seconds.carve);
    const double h = fused.volume.voxel_mm();
    RangeSurfaceOptions with_gaps = surface_options;
    with_gaps.with_gaps = true;
    Carver carver(fused.volume, max_bytes);
    for (const FuseScan& scan : scans) {
        const RangeSurface surface =
            make_range_surface(*scan.image, scan.world_from_scan, with_gaps);
        std::vector<std::array<Eigen::Vector3d, 4>> open;
        if (options.carve_background) open = background_quads(*scan.image, surface);
        carver.carve(
            sight_buffers(surface, fused.ramp_mm, h / 2, 1.5 * h, carver.box_diagonal_mm(), open));
    }
    carver.store(fused.volume);
}

}  // namespace

std::string FuseOptions::validate() const {
    const auto wrong = [](const char* field, double value, const char* bound) {
        return std::string("FuseOptions: ") + field + " = " + std::to_string(value) +
               ", expected " + bound;
    };
    if (!(voxel_mm >= 0 && voxel_mm < 1e6)) return wrong("voxel_mm", voxel_mm, "0 or more");
    if (!(ramp_mm >= 0 && ramp_mm < 1e6)) return wrong("ramp_mm", ramp_mm, "0 or more");
    if (voxel_mm > 0 && ramp_mm > 0 && ramp_mm < 2 * voxel_mm)
        return wrong("ramp_mm", ramp_mm, "at least 2 voxels");
    if (!(max_edge_mm >= 0)) return wrong("max_edge_mm", max_edge_mm, "0 or more");
    if (!(max_incidence_rad > 0 && max_incidence_rad < 1.5708))
        return wrong("max_incidence_rad", max_incidence_rad, "between 0 and pi / 2");
    if (border_taper_cells < 0 || border_taper_cells > 1000)
        return wrong("border_taper_cells", border_taper_cells, "0 to 1000");
    if (fill_smoothing_rounds < 0)
        return wrong("fill_smoothing_rounds", fill_smoothing_rounds, "0 or more");
    if (!(min_component_voxels2 >= 0))
        return wrong("min_component_voxels2", min_component_voxels2, "0 or more");
    if (memory_mb < 1) return wrong("memory_mb", static_cast<double>(memory_mb), "at least 1");
    if (fill_holes && !carve)
        return "FuseOptions: fill_holes needs carve: holes are filled at the border of carved "
               "space";
    if (carve_background && !carve) return "FuseOptions: carve_background needs carve";
    return {};
}

FusedVolume fuse_volume(const std::vector<FuseScan>& scans, const FuseOptions& options) {
    if (const std::string wrong = options.validate(); !wrong.empty())
        throw std::invalid_argument(wrong);
    if (scans.empty()) throw Error("fuse: no scans");
    FusedVolume fused;
    const double h = options.voxel_mm > 0 ? options.voxel_mm : default_voxel_mm(scans);
    fused.volume = SdfVolume(h);
    fused.ramp_mm = options.ramp_mm > 0 ? options.ramp_mm : 2 * h;
    if (fused.ramp_mm < 2 * h)
        throw std::invalid_argument("FuseOptions: ramp_mm = " + std::to_string(fused.ramp_mm) +
                                    ", expected at least 2 voxels of " + std::to_string(h));
    const std::size_t max_bytes = options.memory_mb << 20;
    const RampLengths ramp = {.front_mm = fused.ramp_mm + 1.5 * h,
                              .tail_mm = std::max(2 * h, fused.ramp_mm / 2)};
    const RangeSurfaceOptions surface_options = {
        .max_edge_mm = options.max_edge_mm,
        .max_incidence_rad = options.max_incidence_rad,
        .border_taper_cells = options.border_taper_cells,
        .reference_sigma_mm = options.weight_by_sigma ? reference_sigma_mm(scans) : 0};
    {
        const CpuTimer timer(fused.cpu_seconds.integrate);
        for (const FuseScan& scan : scans) {
            const RangeSurface surface =
                make_range_surface(*scan.image, scan.world_from_scan, surface_options);
            fused.points += valid_count(*scan.image);
            fused.triangles += surface.triangles.size();
            for (const SurfaceVertex& vertex : surface.vertices)
                fused.body.include(vertex.position);
            integrate(fused.volume, surface, ramp, max_bytes);
        }
    }
    if (fused.triangles == 0)
        throw Error(
            "fuse: no scan has a surface: no three neighbouring points with edges up to the "
            "longest allowed");
    fused.body.grow(ramp.front_mm);
    if (options.carve) carve_scans(fused, scans, surface_options, options, max_bytes);
    return fused;
}

TriMesh fused_surface(FusedVolume& fused, const FuseOptions& options) {
    const CpuTimer timer(fused.cpu_seconds.extract);
    return extract_surface(fused.volume, fused.body,
                           {.fill_holes = options.fill_holes,
                            .fill_smoothing_rounds = options.fill_smoothing_rounds,
                            .min_component_voxels2 = options.min_component_voxels2});
}

FuseResult fuse(const std::vector<FuseScan>& scans, const FuseOptions& options) {
    FusedVolume fused = fuse_volume(scans, options);
    FuseResult result;
    result.mesh = fused_surface(fused, options);
    result.voxel_mm = fused.volume.voxel_mm();
    result.ramp_mm = fused.ramp_mm;
    result.points = fused.points;
    result.bricks = fused.volume.bricks().size();
    result.volume_bytes = fused.volume.memory_bytes();
    result.cpu_seconds = fused.cpu_seconds;
    return result;
}

}  // namespace stria
