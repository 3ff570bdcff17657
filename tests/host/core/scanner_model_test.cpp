#include "host/core/scanner_model.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/host/core/random_models.h"

namespace stria {
namespace {

constexpr MachineKind kKinds[] = {MachineKind::swept, MachineKind::rail, MachineKind::turntable};

double random_s(RandomModels& random, MachineKind kind) {
    return kind == MachineKind::rail    ? random.uniform(-100, 100)
           : kind == MachineKind::swept ? random.uniform(-0.1, 0.1)
                                        : random.uniform(-3, 3);
}

ScannerModel random_model(RandomModels& random, MachineKind kind) {
    ScannerModel model;
    model.channels = {random.channel(kind, 0.01), random.channel(kind, 0.01)};
    model.channels[1].camera_id = 1;
    model.channels[1].camera.kind = LensKind::rational8;
    return model;
}

TEST(ScannerModel, PointLiesOnTheRayAndOnTheSheet) {
    RandomModels random(1);
    for (const MachineKind kind : kKinds) {
        int met = 0;
        for (int i = 0; i < 300; ++i) {
            const Channel channel = random.channel(kind, 0.01);
            const double s = random_s(random, kind);
            const Eigen::Vector2d pixel(random.uniform(300, 980), random.uniform(200, 820));
            const auto found = triangulate(channel, pixel, s);
            if (!found) continue;
            ++met;
            const Rigid3 scan = scan_from_camera(channel, s);
            const Eigen::Vector3d in_camera = scan.inverse() * found->point_in_scan;
            const auto back = project(channel.camera, in_camera);
            ASSERT_TRUE(back);
            EXPECT_LT((*back - pixel).norm(), 1e-8);                                 // px
            EXPECT_NEAR(signed_distance(sheet_at(channel, s), in_camera), 0, 1e-8);  // mm
            const Eigen::Vector3d centre = scan.translation;
            EXPECT_LT(((found->point_in_scan - centre).normalized() - found->ray_in_scan).norm(),
                      1e-12);
        }
        EXPECT_GT(met, 250) << name_of(kind);
    }
}

TEST(ScannerModel, DerivativesAgreeWithCentralDifferences) {
    RandomModels random(2);
    for (const MachineKind kind : kKinds)
        for (int i = 0; i < 200; ++i) {
            const Channel channel = random.channel(kind, 0.01);
            const double s = random_s(random, kind);
            const Eigen::Vector2d pixel(random.uniform(300, 980), random.uniform(200, 820));
            const auto found = triangulate(channel, pixel, s);
            if (!found) continue;
            const auto difference = [&](const Eigen::Vector2d& step, double ds, double h) {
                const auto after = triangulate(channel, pixel + step, s + ds);
                const auto before = triangulate(channel, pixel - step, s - ds);
                if (!after || !before) return Eigen::Vector3d(Eigen::Vector3d::Zero());
                return Eigen::Vector3d((after->point_in_scan - before->point_in_scan) / (2 * h));
            };
            const double hs = kind == MachineKind::rail ? 1e-2 : 1e-5;
            const auto check = [&](const Eigen::Vector3d& ours, const Eigen::Vector3d& numeric) {
                // Both sides are differences of points of 300 mm: 1e-5 relative and 1e-4 mm
                EXPECT_LT((ours - numeric).norm(), 1e-5 * numeric.norm() + 1e-4)
                    << name_of(kind) << " " << ours.transpose() << " / " << numeric.transpose();
            };
            check(found->d_point_d_u, difference({1e-3, 0}, 0, 1e-3));
            check(found->d_point_d_v, difference({0, 1e-3}, 0, 1e-3));
            check(found->d_point_d_s, difference({0, 0}, hs, hs));
        }
}

TEST(ScannerModel, AFlatSheetIsMetWhereThePlaneEquationSays) {
    RandomModels random(3);
    for (int i = 0; i < 200; ++i) {
        const Channel channel = random.channel(MachineKind::rail, 0);
        const Eigen::Vector2d pixel(random.uniform(300, 980), random.uniform(200, 820));
        const auto found = triangulate(channel, pixel, 0);
        ASSERT_TRUE(found);
        const Eigen::Vector3d ray = ray_through(channel.camera, pixel);
        const Eigen::Vector3d point =
            ray * (channel.sheet.offset_mm / channel.sheet.normal.dot(ray));
        const Eigen::Vector3d in_scan(point.x(), -point.y(), -point.z());  // y up, along -z
        EXPECT_LT((found->point_in_scan - in_scan).norm(), 1e-9);
    }
}

TEST(ScannerModel, GrazingAndBackwardRaysMeetNothing) {
    Channel channel;
    channel.camera = {LensKind::pinhole, 100, 100, 100, 100, 50, 50, {}};
    channel.axis.kind = MachineKind::rail;
    channel.sheet.normal = Eigen::Vector3d(1, 0, 0);
    channel.sheet.offset_mm = 50;
    EXPECT_FALSE(triangulate(channel, {50, 50}, 0));    // parallel
    EXPECT_FALSE(triangulate(channel, {50.5, 50}, 0));  // 0.005 rad
    EXPECT_FALSE(triangulate(channel, {20, 50}, 0));    // leads away
    EXPECT_TRUE(triangulate(channel, {80, 50}, 0));
}

TEST(ScanFromCamera, FollowsTheMachine) {
    Channel channel;
    const Eigen::Vector3d p(1, 2, 3);
    channel.axis.kind = MachineKind::swept;
    EXPECT_EQ(scan_from_camera(channel, 0.7) * p, Eigen::Vector3d(1, -2, -3));
    channel.axis.kind = MachineKind::rail;
    channel.axis.rail.direction = {0, 1, 0};  // down in the image: the head moves to -y of the scan
    EXPECT_EQ(scan_from_camera(channel, 10) * p, Eigen::Vector3d(1, -12, -3));
    channel.axis.kind = MachineKind::turntable;  // table frame = camera frame here
    // The table has turned counter-clockwise by 90 deg: what is seen at +y was at +x at s = 0.
    const Eigen::Vector3d seen(0, 5, 1);
    EXPECT_LT(
        (scan_from_camera(channel, std::numbers::pi / 2) * seen - Eigen::Vector3d(5, 0, 1)).norm(),
        1e-12);
}

TEST(SheetAt, TurnsTheBeamByTwiceTheMirrorsAngle) {
    Channel channel;
    channel.axis.kind = MachineKind::swept;
    channel.axis.mirror.direction = {0, 1, 0};
    channel.axis.mirror.normal0 = Eigen::Vector3d(-1, 0, 1).normalized();
    channel.axis.mirror.point = {100, 0, 0};
    channel.sheet.apex = {100, 0, 100};  // shines along -z onto the mirror at (100, 0, 0)
    channel.sheet.central_ray = {0, 0, -1};
    channel.sheet.normal = {1, 0, 0};
    channel.sheet.offset_mm = 100;
    for (const double s : {-0.1, 0.0, 0.05}) {
        const Eigen::Vector3d ray = sheet_at(channel, s).central_ray;
        const double angle = std::atan2(ray.x(), -ray.z());
        const double at_zero =
            std::atan2(sheet_at(channel, 0).central_ray.x(), -sheet_at(channel, 0).central_ray.z());
        EXPECT_NEAR(std::abs(angle - at_zero), std::abs(2 * s), 1e-12);
        // The axis lies on the mirror: the beam always leaves from it.
        EXPECT_NEAR(signed_distance(sheet_at(channel, s), {100, 7, 0}), 0, 1e-12);
    }
}

TEST(Perturbed, ByNothingIsTheModelItself) {
    RandomModels random(4);
    for (const MachineKind kind : kKinds) {
        const ScannerModel model = random_model(random, kind);
        const auto count = static_cast<Eigen::Index>(parameter_names(model).size());
        const ScannerModel same = perturbed(model, Eigen::VectorXd::Zero(count));
        for (std::size_t c = 0; c < 2; ++c)
            for (int i = 0; i < 20; ++i) {
                const Eigen::Vector2d pixel(random.uniform(300, 980), random.uniform(200, 820));
                const double s = random_s(random, kind);
                const auto a = triangulate(model.channels[c], pixel, s);
                const auto b = triangulate(same.channels[c], pixel, s);
                ASSERT_EQ(a.has_value(), b.has_value());
                if (a) {
                    EXPECT_LT((a->point_in_scan - b->point_in_scan).norm(), 1e-9);
                }
            }
    }
}

TEST(Perturbed, TakesOneNumberForEachName) {
    RandomModels random(5);
    for (const MachineKind kind : kKinds) {
        const ScannerModel model = random_model(random, kind);
        const std::vector<std::string> names = parameter_names(model);
        EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
        const std::size_t axis = kind == MachineKind::swept ? 9 : kind == MachineKind::rail ? 2 : 6;
        // lens 4 + 5 and 4 + 8, sheet 5 each, delay 1 each
        EXPECT_EQ(names.size(), 9 + 12 + 2 * (5 + axis + 1));
        // The last number moves the last parameter, axis.delay of the last channel.
        Eigen::VectorXd delta = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(names.size()));
        delta[delta.size() - 1] = 5;
        EXPECT_EQ(names.back(), "channel1.axis.delay");
        EXPECT_EQ(perturbed(model, delta).channels[1].axis.delay_ns,
                  model.channels[1].axis.delay_ns + 5);
        EXPECT_EQ(perturbed(model, delta).channels[0].axis.delay_ns,
                  model.channels[0].axis.delay_ns);
    }
}

TEST(Perturbed, EveryParameterMovesPointsSmoothly) {
    RandomModels random(6);
    for (const MachineKind kind : kKinds) {
        const ScannerModel model = random_model(random, kind);
        const std::vector<std::string> names = parameter_names(model);
        std::vector<bool> moves(names.size(), false);
        for (int i = 0; i < 20; ++i) {
            const Eigen::Vector2d pixel(random.uniform(300, 980), random.uniform(200, 820));
            const double s = kind == MachineKind::rail ? 30 : 0.05;
            for (std::size_t k = 0; k < names.size(); ++k) {
                const std::size_t c = names[k][7] == '0' ? 0 : 1;
                Eigen::VectorXd delta =
                    Eigen::VectorXd::Zero(static_cast<Eigen::Index>(names.size()));
                const auto moved = [&](double step) {
                    delta[static_cast<Eigen::Index>(k)] = step;
                    return triangulate(perturbed(model, delta).channels[c], pixel, s);
                };
                const auto zero = moved(0), one = moved(1e-5), two = moved(2e-5);
                if (!zero || !one || !two) continue;
                const Eigen::Vector3d first = one->point_in_scan - zero->point_in_scan;
                const Eigen::Vector3d second = two->point_in_scan - one->point_in_scan;
                moves[k] = moves[k] || first.norm() > 1e-9;
                // mm: a second derivative of up to 1e4 mm (range over the cube of the incidence)
                EXPECT_LT((second - first).norm(), 0.05 * first.norm() + 1e-6) << names[k];
            }
        }
        for (std::size_t k = 0; k < names.size(); ++k)  // a delay moves times, not points
            EXPECT_EQ(moves[k], names[k].find("delay") == std::string::npos) << names[k];
    }
}

TEST(TangentBasis, IsOrthonormalAndRightHandedAroundN) {
    RandomModels random(7);
    for (int i = 0; i < 200; ++i) {
        const Eigen::Vector3d n = i < 3 ? Eigen::Vector3d(Eigen::Vector3d::Unit(i)) : random.unit();
        Eigen::Vector3d a, b;
        tangent_basis(n, a, b);
        EXPECT_NEAR(a.norm(), 1, 1e-12);
        EXPECT_NEAR(b.norm(), 1, 1e-12);
        EXPECT_LT((n.cross(a) - b).norm(), 1e-12);
        EXPECT_NEAR(a.dot(n), 0, 1e-12);
    }
}

TEST(ScannerModel, FindsChannelsAndNames) {
    RandomModels random(8);
    const ScannerModel model = random_model(random, MachineKind::rail);
    EXPECT_EQ(find_channel(model, 1, 0), &model.channels[1]);
    EXPECT_EQ(find_channel(model, 1, 1), nullptr);
    for (const MachineKind kind : kKinds) EXPECT_EQ(machine_kind_from(name_of(kind)), kind);
    EXPECT_FALSE(machine_kind_from("mirror"));
}

TEST(ScannerModel, NamesTheFieldThatIsWrong) {
    RandomModels random(9);
    const auto why = [&](auto change) {
        ScannerModel model = random_model(random, MachineKind::swept);
        change(model);
        return validate(model);
    };
    const auto has = [](const std::string& text, const std::string& part) {
        return text.find(part) != std::string::npos;
    };
    EXPECT_EQ(why([](ScannerModel&) {}), "");
    EXPECT_TRUE(has(why([](ScannerModel& m) { m.channels.clear(); }), "[[channel]]"));
    EXPECT_TRUE(
        has(why([](ScannerModel& m) { m.channels[1].camera.fx = 0; }), "channel 1: camera.fx"));
    EXPECT_TRUE(has(why([](ScannerModel& m) { m.channels[0].sheet.normal *= 2; }), "sheet.normal"));
    EXPECT_TRUE(has(why([](ScannerModel& m) { m.channels[0].sheet.waist_sigma_mm = 0; }),
                    "waist_sigma_mm"));
    EXPECT_TRUE(has(why([](ScannerModel& m) { m.covariance.setZero(3, 3); }), "covariance"));
}

}  // namespace
}  // namespace stria
