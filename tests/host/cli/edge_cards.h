#pragma once
#include <array>
#include <string>
#include <vector>

#include "firmware/stripe/peak_methods.h"
#include "host/link/recording_contents.h"
#include "sim/scene.h"

/// Cards of two reflectances, 10:1, at three depths of a rail's or turntable's field, rendered
/// noise-free, and what each way of analysing their frames makes of them.
namespace stria::test_support {

struct EdgeCards {
    Scene scene;
    ScanPlan plan;               ///< record = frames
    double footprint_ratio = 0;  ///< sigma_p / sigma_b in the middle of the field
};

/// @param rows          of the camera
/// @param psf_sigma_px  of its lens
EdgeCards edge_cards(MachineKind kind, int rows, double psf_sigma_px);

/// Where a method saw the sheet's centre: pixel and axis position.
struct Crossing {
    double u = 0, v = 0, s = 0;
};

/// The sweep's frames with the log; one rendering serves every method.
RecordingContents sweep_of(const EdgeCards& cards);

std::vector<Crossing> spatial_crossings(const RecordingContents& sweep, PeakMethod method);
/// The rotated spacetime image (rotated_spacetime.h), its one angle from the middle of the field.
std::vector<Crossing> rotated_crossings(const RecordingContents& sweep, const EdgeCards& cards);
/// Maximum likelihood along one straight path for the whole field: the same angle, our fit.
std::vector<Crossing> straight_crossings(const RecordingContents& sweep, const EdgeCards& cards);
std::vector<Crossing> path_crossings(const RecordingContents& sweep, const EdgeCards& cards);

/// tan(theta_ST) in the middle of the field: by the paper's construction, the apparent travel on
/// the sheet in pixels of depth a step, which is dx / (dz tan theta) where the part moves square to
/// the sheet; and from the table of image paths there.
std::array<double, 2> rotation_tangents(const EdgeCards& cards);

/// Distances of the points from their cards' planes, points nearer than four beam widths or
/// three rows to a card's own border left out.
struct EdgeErrors {
    std::size_t points = 0;
    double worst_mm = 0, p95_mm = 0, rms_mm = 0;
};
EdgeErrors judge(const std::vector<Crossing>& crossings, const EdgeCards& cards);

void print(const std::string& what, const EdgeErrors& errors);

}  // namespace stria::test_support
