#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "host/fusion/range_surface.h"

namespace stria {

/// How far one can see into the free space in front of a surface, from one place or along one
/// direction: a small depth image with pyramids of its minimum and maximum.
class SightBuffer {
  public:
    /// @param triangles  of the surface; those with a corner that must not carve block the view
    /// @param laser      look along the laser's rays instead of the camera's
    /// @param ramp_mm    sight ends 3 sigma + ramp_mm in front of the surface
    /// @param pixel_mm   wanted size of a pixel at the surface
    /// @param open       quads (world) that one sees through without end, where no triangle stands
    SightBuffer(const RangeSurface& surface, const std::vector<std::uint32_t>& triangles,
                bool laser, double ramp_mm, double pixel_mm,
                const std::vector<std::array<Eigen::Vector3d, 4>>& open = {});

    enum class Answer { none, some, all };
    /// Which of the points of an axis-parallel box are seen to be free.
    Answer sees_box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) const;
    /// Sets bit x + 8 y of bits[z] for every voxel of an 8^3 brick that is seen to be free.
    void sees_voxels(const Eigen::Vector3d& first, double voxel_mm, std::uint64_t bits[8]) const;

  private:
    struct Pixel {
        double u, v, range;
    };
    struct Level {
        int width = 0, height = 0;
        std::vector<float> low, high;
    };
    void set_view(const RangeSurface& surface, const std::vector<std::uint32_t>& triangles,
                  bool laser, double pixel_mm,
                  const std::vector<std::array<Eigen::Vector3d, 4>>& open);
    template <typename Paint>
    void draw(const std::array<Eigen::Vector3d, 3>& corners, const Paint& paint) const;
    void draw_surface(const RangeSurface& surface, const std::vector<std::uint32_t>& triangles,
                      double ramp_mm);
    void close_undrawn(const std::vector<std::array<Eigen::Vector3d, 4>>& open);
    void build_levels();
    bool project(const Eigen::Vector3d& point, Pixel& pixel) const;
    void add_level();

    bool orthographic_ = false;
    Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
    Eigen::Matrix3d axes_ = Eigen::Matrix3d::Identity();  ///< rows: right, down, forwards
    double scale_ = 1, u0_ = 0, v0_ = 0;
    int width_ = 0, height_ = 0;
    std::vector<float> free_mm_;  ///< along the ray; +inf: nothing drawn yet
    std::vector<Level> levels_;   ///< 0: the pixels themselves
};

}  // namespace stria
