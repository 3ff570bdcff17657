#include "host/core/rigid3.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>
#include <numbers>

#include "tests/host/core/random_models.h"

namespace stria {
namespace {

TEST(Rigid3, ComposesAsNamesCancel) {
    RandomModels random(1);
    for (int i = 0; i < 200; ++i) {
        const Rigid3 a = random.motion(100), b = random.motion(100);
        const Eigen::Vector3d p = random.vector(100);
        EXPECT_LT(((a * b) * p - a * (b * p)).norm(), 1e-11);  // mm, rounding at 300 mm
        EXPECT_LT((a.inverse() * (a * p) - p).norm(), 1e-11);
    }
}

TEST(Rigid3, TurnsByTheRightHand) {
    const Eigen::Matrix3d quarter = rotation_from_vector({0, 0, std::numbers::pi / 2});
    EXPECT_LT((quarter * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-15);
}

/// exp of the cross-product matrix as its power series: slow and obvious.
Eigen::Matrix3d exponential(const Eigen::Vector3d& w) {
    Eigen::Matrix3d cross;
    cross << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
    Eigen::Matrix3d sum = Eigen::Matrix3d::Identity(), term = sum;
    for (int n = 1; n < 60; ++n) {
        term = term * cross / n;
        sum += term;
    }
    return sum;
}

TEST(Rotation, IsTheExponentialOfItsVector) {
    RandomModels random(2);
    for (const double angle : {0.0, 1e-300, 1e-12, 1e-6, 0.1, 1.0, 3.0}) {
        const Eigen::Vector3d w = angle * random.unit();
        EXPECT_LT((rotation_from_vector(w) - exponential(w)).norm(), 1e-13) << angle;
    }
}

TEST(Rotation, GivesItsVectorBack) {
    RandomModels random(3);
    for (const double angle : {0.0, 1e-200, 1e-9, 1e-3, 1.0, 3.0, 3.14159}) {
        const Eigen::Vector3d w = angle * random.unit();
        EXPECT_LT((vector_from_rotation(rotation_from_vector(w)) - w).norm(), 1e-9) << angle;
    }
    // Half a turn has two vectors, either is right.
    const Eigen::Matrix3d half = rotation_from_vector({0, std::numbers::pi, 0});
    EXPECT_NEAR(vector_from_rotation(half).norm(), std::numbers::pi, 1e-12);
    EXPECT_NEAR(std::abs(vector_from_rotation(half).y()), std::numbers::pi, 1e-12);
}

TEST(Rigid3, GivesItsSixNumbersBack) {
    RandomModels random(4);
    for (int i = 0; i < 100; ++i) {
        Vector6d delta;
        delta << random.uniform(0, 3) * random.unit(), random.vector(500);
        EXPECT_LT((vector_from_rigid(rigid_from_vector(delta)) - delta).norm(), 1e-11);
    }
}

TEST(NearestRotation, LeavesRotationsAndRestoresDisturbedOnes) {
    RandomModels random(5);
    for (int i = 0; i < 100; ++i) {
        const Eigen::Matrix3d rotation = random.motion(0).rotation;
        EXPECT_LT((nearest_rotation(rotation) - rotation).norm(), 1e-14);
        // A symmetric stretch does not turn: the polar factor is the rotation itself.
        const Eigen::Vector3d stretch(1.01, 0.98, 1.03);
        EXPECT_LT((nearest_rotation(rotation * stretch.asDiagonal()) - rotation).norm(), 1e-13);
    }
    const Eigen::Matrix3d mirror = Eigen::Vector3d(1, 1, -1).asDiagonal();
    EXPECT_NEAR(nearest_rotation(mirror).determinant(), 1, 1e-12);
}

TEST(IsRigid, RefusesMirrorsStretchesAndNan) {
    RandomModels random(6);
    Rigid3 motion = random.motion(100);
    EXPECT_TRUE(is_rigid(motion));
    Rigid3 mirror = motion;
    mirror.rotation.col(0) = -mirror.rotation.col(0);
    EXPECT_FALSE(is_rigid(mirror));
    Rigid3 stretched = motion;
    stretched.rotation *= 1.001;
    EXPECT_FALSE(is_rigid(stretched));
    EXPECT_TRUE(is_rigid(stretched, 0.01));
    motion.translation.x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(is_rigid(motion));
}

}  // namespace
}  // namespace stria
