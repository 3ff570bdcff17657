#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace stria {

constexpr int kMaxPathNodes = 257;  ///< a side

/// How the image of a surface point moves while the part passes the sheet, of the point that the
/// sheet's centre crosses at a pixel (u, v): after ds more of axis travel it is seen at
/// u + du ds + ddu ds^2 / 2, and v alike.
struct ImagePath {
    double du = 0, dv = 0;    ///< px per unit of s
    double ddu = 0, ddv = 0;  ///< px per unit of s squared
    double width_s = 0;       ///< of the pulse expected, standard deviation, unit of s
};

/// Image paths of a rail or turntable on a coarse grid of nodes spread evenly over the image's
/// pixel centres, corners included, row-major: what a scanner needs to know about its calibration
/// to analyse in spacetime. Computed on the host (host/scan/path_table.h). Per node what ImagePath
/// holds.
struct PathTable {
    std::uint8_t camera_id = 0;
    std::uint8_t laser_id = 0;
    int image_width = 0;
    int image_height = 0;
    int nodes_x = 0;
    int nodes_y = 0;
    std::string model_hash;               ///< of the scanner model that it was computed from
    std::vector<float> du_ds, dv_ds;      ///< px per unit of s
    std::vector<float> d2u_ds2, d2v_ds2;  ///< px per unit of s squared
    std::vector<float> width_s;           ///< expected pulse width, standard deviation, unit of s
    std::vector<std::uint8_t> valid;      ///< 1: the node sees the sheet inside the valid volume
    bool operator==(const PathTable&) const = default;
};

/// Path of the point that the sheet's centre crosses at (u, v), linear between the four nodes about
/// it; empty outside the image or where one of them is not valid. The table must be usable.
std::optional<ImagePath> path_at(const PathTable& table, double u, double v);

/// Empty if usable, else what is wrong (field, value, bound).
std::string validate(const PathTable& table);

}  // namespace stria
