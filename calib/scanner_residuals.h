#pragma once
#include <ceres/jet.h>
#include <ceres/sized_cost_function.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "calib/scanner_cost.h"
#include "calib/stripe_points.h"

/// For calib's own .cpp files only: the residuals of the scanner's joint problem as Ceres functors.
namespace stria {

/// Corner of the board seen at s, whitened.
template <MachineKind kKind>
struct CornerCost {
    const Channel* base;
    BoardPoint point;
    Eigen::Vector2d pixel;
    double s, inverse_sigma;

    template <typename T>
    bool operator()(const T* camera, const T* axis, const T* pose, const T* warp,
                    T* residual) const {
        const Vec3<T> on_board = point.bent_by(warp);
        Vec3<T> moved;
        move_by_block(pose, on_board.data(), moved.data());
        moved = moved_by_axis<kKind>(base->axis, axis, T(s), moved);
        if (!project_block(camera, moved.data(), residual)) return false;
        residual[0] = (residual[0] - pixel.x()) * inverse_sigma;
        residual[1] = (residual[1] - pixel.y()) * inverse_sigma;
        return true;
    }
};

/// Corner of a board whose pictures were all taken at one place of camera and board.
struct StillCornerCost {
    BoardPoint point;
    Eigen::Vector2d pixel;
    double inverse_sigma;

    template <typename T>
    bool operator()(const T* camera, const T* pose, const T* warp, T* residual) const {
        const Vec3<T> on_board = point.bent_by(warp);
        Vec3<T> moved;
        move_by_block(pose, on_board.data(), moved.data());
        if (!project_block(camera, moved.data(), residual)) return false;
        residual[0] = (residual[0] - pixel.x()) * inverse_sigma;
        residual[1] = (residual[1] - pixel.y()) * inverse_sigma;
        return true;
    }
};

/// Sheet and mirror with their derivatives at one set of parameters: the same for every stripe
/// point of an evaluation, so the points of a problem share one and the first to see new parameters
/// renews it. Not for use from several threads.
template <MachineKind kKind>
class LightAt {
  public:
    static constexpr bool kStill = kKind == MachineKind::swept;
    static constexpr int kAxis = axis_size(kKind);
    static constexpr int kSize = kSheetSize + (kStill ? kAxis : 0);
    using Light = ceres::Jet<double, kSize>;

    /// The sheet at a point's s, every derivative by sheet and (swept) mirror parameters.
    SheetOf<Light> at(const Channel& base, const double* sheet, const double* axis,
                      const StripePoint& point) {
        if (!known_ || !std::equal(sheet, sheet + kSheetSize, key_.begin()) ||
            (kStill && !std::equal(axis, axis + kAxis, key_.begin() + kSheetSize)))
            renew(base, sheet, axis);
        if constexpr (kStill)
            return reflected_sheet(sheet_, mirror_,
                                   delayed_s<kKind>(point, base.axis, axis_.data()));
        else
            return sheet_;
    }

  private:
    void renew(const Channel& base, const double* sheet, const double* axis) {
        Light d[kSheetSize];
        for (int i = 0; i < kSheetSize; ++i) {
            key_[static_cast<std::size_t>(i)] = sheet[i];
            d[i] = Light(sheet[i], i);
        }
        for (int i = 0; kStill && i < kAxis; ++i) {
            key_[static_cast<std::size_t>(kSheetSize + i)] = axis[i];
            axis_[static_cast<std::size_t>(i)] =
                Light(axis[i], std::min(kSheetSize + i, kSize - 1));
        }
        sheet_ = sheet_of<kKind>(base, d, axis_.data());
        if constexpr (kStill) mirror_ = moved_mirror(base.axis.mirror, axis_.data());
        known_ = true;
    }

    bool known_ = false;
    std::array<double, kSheetSize + kMostAxisSize> key_{};
    std::array<Light, kMostAxisSize> axis_{};
    SheetOf<Light> sheet_;
    MirrorOf<Light> mirror_;
};

/// Distance of a stripe point from the sheet, whitened. The chain rule is taken by hand between
/// three short dual numbers (ray and board, sheet and mirror, point), which is several times as
/// fast as one long one over all 35 parameters.
template <MachineKind kKind>
class StripeCost : public ceres::SizedCostFunction<1, kCameraSize, kSheetSize, axis_size(kKind),
                                                   kPoseSize, kWarpSize> {
  public:
    /// @param rise  of the board where the point lies, see BoardRise
    StripeCost(const Channel* base, std::shared_ptr<LightAt<kKind>> light, const StripePoint& point,
               const Eigen::Vector2d& rise, double sigma_mm)
        : base_(base),
          light_(std::move(light)),
          point_(point),
          rise_(rise),
          inverse_sigma_(1 / sigma_mm) {}

    bool Evaluate(double const* const* blocks, double* residual,
                  double** jacobians) const override {
        const double* camera = blocks[0];
        Eigen::Vector2d ray;
        camera_math::undistort(camera + 4, (point_.pixel.x() - camera[2]) / camera[0],
                               (point_.pixel.y() - camera[3]) / camera[1], ray.x(), ray.y());
        if (!jacobians) {
            const Vec3<double> p = point_on_board(ray.data(), blocks[3], blocks[2], blocks[4]);
            residual[0] = distance_from(sheet_now(blocks[1], blocks[2]), p) * inverse_sigma_;
            return true;
        }
        // Point by ray (2), pose (6), warp (2) and, where the axis moves the board, axis.
        constexpr int kMoved = kStill ? 0 : kAxis;
        constexpr int kWarpAt = 2 + kPoseSize, kAxisAt = kWarpAt + kWarpSize;
        using Moved = ceres::Jet<double, kAxisAt + kMoved>;
        Moved ray_d[2], pose_d[kPoseSize], axis_d[kAxis], warp_d[kWarpSize];
        for (int i = 0; i < 2; ++i) ray_d[i] = Moved(ray[i], i);
        for (int i = 0; i < kPoseSize; ++i) pose_d[i] = Moved(blocks[3][i], 2 + i);
        for (int i = 0; i < kAxis; ++i)
            axis_d[i] = kStill ? Moved(blocks[2][i]) : Moved(blocks[2][i], kAxisAt + i);
        for (int i = 0; i < kWarpSize; ++i) warp_d[i] = Moved(blocks[4][i], kWarpAt + i);
        const Vec3<Moved> point = point_on_board(ray_d, pose_d, axis_d, warp_d);
        const Vec3<double> at(point[0].a, point[1].a, point[2].a);

        // Distance by sheet (5) and, where the axis is the mirror's, axis; the point kept.
        using Light = typename LightAt<kKind>::Light;
        const SheetOf<Light> sheet = light_->at(*base_, blocks[1], blocks[2], point_);
        const Light distance = distance_from(sheet, Vec3<Light>(at.cast<Light>()));
        residual[0] = distance.a * inverse_sigma_;

        // Distance by point, the sheet kept.
        using Near = ceres::Jet<double, 3>;
        const SheetOf<Near> still = {values_of<Near>(sheet.normal),
                                     values_of<Near>(sheet.apex),
                                     values_of<Near>(sheet.central_ray),
                                     Near(sheet.offset.a),
                                     Near(sheet.bow2.a),
                                     Near(sheet.bow3.a)};
        const Vec3<Near> near_at(Near(at[0], 0), Near(at[1], 1), Near(at[2], 2));
        const Eigen::Vector3d slope = distance_from(still, near_at).v;
        Eigen::Matrix<double, kAxisAt + kMoved, 1> by_moved =
            slope[0] * point[0].v + slope[1] * point[1].v + slope[2] * point[2].v;
        by_moved *= inverse_sigma_;
        if (jacobians[0]) put_camera(camera, by_moved.template head<2>(), jacobians[0]);
        for (int i = 0; jacobians[1] && i < kSheetSize; ++i)
            jacobians[1][i] = distance.v[i] * inverse_sigma_;
        for (int i = 0; jacobians[2] && i < kAxis; ++i)
            jacobians[2][i] =
                kStill ? distance.v[std::min<int>(kSheetSize + i, Light::DIMENSION - 1)] *
                             inverse_sigma_
                       : by_moved[std::min<int>(kAxisAt + i, int(by_moved.size()) - 1)];
        for (int i = 0; jacobians[3] && i < kPoseSize; ++i) jacobians[3][i] = by_moved[2 + i];
        for (int i = 0; jacobians[4] && i < kWarpSize; ++i) jacobians[4][i] = by_moved[kWarpAt + i];
        return true;
    }

  private:
    static constexpr int kAxis = axis_size(kKind);
    static constexpr bool kStill = kKind == MachineKind::swept;

    template <typename T, typename From>
    static Vec3<T> values_of(const From& v) {
        return Vec3<T>(T(v[0].a), T(v[1].a), T(v[2].a));
    }

    template <typename T>
    SheetOf<T> sheet_now(const T* sheet, const T* axis) const {
        const SheetOf<T> moved = sheet_of<kKind>(*base_, sheet, axis);
        if constexpr (kStill)
            return reflected_sheet(moved, moved_mirror(base_->axis.mirror, axis),
                                   delayed_s<kKind>(point_, base_->axis, axis));
        else
            return moved;
    }

    template <typename T>
    Vec3<T> point_on_board(const T* ray, const T* pose, const T* axis, const T* warp) const {
        return meet_board<kKind>(base_->axis, axis, pose, Vec3<T>(ray[0], ray[1], T(1)),
                                 delayed_s<kKind>(point_, base_->axis, axis),
                                 T(warp[0] * rise_.x() + warp[1] * rise_.y()));
    }

    void put_camera(const double* camera, const Eigen::Vector2d& by_ray, double* jacobian) const {
        using Lens = ceres::Jet<double, kCameraSize>;
        Lens camera_d[kCameraSize], ray[3];
        for (int i = 0; i < kCameraSize; ++i) camera_d[i] = Lens(camera[i], i);
        ray_of_block(camera_d, point_.pixel, camera, ray);
        for (int i = 0; i < kCameraSize; ++i)
            jacobian[i] = by_ray[0] * ray[0].v[i] + by_ray[1] * ray[1].v[i];
    }

    const Channel* base_;
    std::shared_ptr<LightAt<kKind>> light_;  ///< shared by the points of one problem
    StripePoint point_;
    Eigen::Vector2d rise_;
    double inverse_sigma_;
};

/// How far a machine may be from its drawing, standard deviations.
struct NominalSigmas {
    double angle_rad, length_mm, bow, gain, delay_ns;
};

/// Weak pull of the board towards flatness.
struct WarpPrior {
    double sigma_mm;

    template <typename T>
    bool operator()(const T* warp, T* residual) const {
        for (int i = 0; i < kWarpSize; ++i) residual[i] = warp[i] / sigma_mm;
        return true;
    }
};

/// Weak pull of a sheet towards the nominal one.
template <MachineKind kKind>
struct SheetPrior {
    static constexpr int kSize = 6;
    const Channel* base;
    const LaserSheet* nominal;
    NominalSigmas sigma;

    template <typename T>
    bool operator()(const T* sheet_delta, const T* axis_delta, T* residual) const {
        const SheetOf<T> sheet = sheet_of<kKind>(*base, sheet_delta, axis_delta);
        const double side = base->sheet.normal.dot(nominal->normal) < 0 ? -1 : 1;
        for (int i = 0; i < 3; ++i)
            residual[i] = (sheet.normal[i] - side * nominal->normal[i]) / sigma.angle_rad;
        residual[3] = (sheet.offset - side * nominal->offset_mm) / sigma.length_mm;
        residual[4] = (sheet.bow2 - side * nominal->bow2) / sigma.bow;
        residual[5] = (sheet.bow3 - nominal->bow3) / sigma.bow;
        return true;
    }
};

/// The same for the axis: differences of directions and positions. A position along the axis means
/// nothing and is left out.
template <MachineKind kKind>
struct AxisPrior {
    static constexpr int kSize = kKind == MachineKind::swept  ? 13
                                 : kKind == MachineKind::rail ? 4
                                                              : 7;
    const Channel* base;
    const AxisModel* nominal;
    NominalSigmas sigma;

    template <typename T>
    bool operator()(const T* axis_delta, T* residual) const {
        int next = 0;
        const auto put = [&](const T& value) { residual[next++] = value; };
        const auto put3 = [&](const Vec3<T>& difference, double by) {
            for (int i = 0; i < 3; ++i) put(difference[i] / by);
        };
        const auto square_to = [](const Vec3<T>& v, const Eigen::Vector3d& axis) -> Vec3<T> {
            const Vec3<T> unit = axis.cast<T>();
            return v - unit * unit.dot(v);
        };
        if constexpr (kKind == MachineKind::swept) {
            const MirrorOf<T> mirror = moved_mirror(base->axis.mirror, axis_delta);
            const MirrorAxis& drawn = nominal->mirror;
            put3(mirror.direction - drawn.direction.cast<T>(), sigma.angle_rad);
            put3(square_to(mirror.point - drawn.point.cast<T>(), drawn.direction), sigma.length_mm);
            put3(mirror.normal0 - drawn.normal0.cast<T>(), sigma.angle_rad);
            put((mirror.offset - drawn.offset_mm) / sigma.length_mm);
            put((mirror.g2 - drawn.g2) / sigma.gain);
            put((mirror.g3 - drawn.g3) / sigma.gain);
        } else if constexpr (kKind == MachineKind::rail) {
            put3(turned_by(base->axis.rail.direction, axis_delta[0], axis_delta[1]) -
                     nominal->rail.direction.cast<T>(),
                 sigma.angle_rad);
        } else {
            // The table's axis as two points of the camera frame: where it is at its origin, and
            // which way it points.
            const Vec3<T> origin = in_camera(axis_delta, Eigen::Vector3d::Zero());
            const Vec3<T> up = in_camera(axis_delta, Eigen::Vector3d::UnitZ()) - origin;
            const Rigid3 drawn = nominal->turntable.table_from_camera.inverse();
            put3(up - drawn.rotation.col(2).template cast<T>(), sigma.angle_rad);
            put3(square_to(origin - drawn.translation.cast<T>(), drawn.rotation.col(2)),
                 sigma.length_mm);
        }
        put((axis_delta[axis_size(kKind) - 1] + base->axis.delay_ns - nominal->delay_ns) /
            sigma.delay_ns);
        return true;
    }

    template <typename T>
    Vec3<T> in_camera(const T* d, const Eigen::Vector3d& on_table) const {
        const Vec3<T> shifted(on_table.x() - d[3], on_table.y() - d[4], on_table.z() - d[5]);
        const T back[3] = {-d[0], -d[1], -d[2]};
        Vec3<T> r;
        ceres::AngleAxisRotatePoint(back, shifted.data(), r.data());
        const Rigid3& table = base->axis.turntable.table_from_camera;
        return table.rotation.transpose().cast<T>() * (r - table.translation.cast<T>());
    }
};

}  // namespace stria
