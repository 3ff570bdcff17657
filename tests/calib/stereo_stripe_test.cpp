// Real stereo images of a swept stripe: peaks of both cameras, triangulated with a calibration by
// OpenCV, must lie in one plane a frame, since the laser's sheet is one.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "firmware/core/median.h"
#include "firmware/stripe/noise_estimate.h"
#include "firmware/stripe/spacetime.h"
#include "firmware/stripe/spatial.h"
#include "host/core/frame_image.h"
#include "host/io/image_io.h"

namespace stria {
namespace {

constexpr int kBoardSide = 7;          // inner corners, one square apart: the unit is a square
constexpr int kFirst = 3, kLast = 23;  // the frames in which the stripe is seen

std::string data_folder() {
    const char* root = std::getenv("STRIA_TEST_DATA");
    return root ? std::string(root) + "/laser_sweep_stereo_suzanne" : std::string();
}

std::string file_name(const char* pattern, int number) {
    char text[64];
    std::snprintf(text, sizeof text, pattern, number);
    return data_folder() + "/" + text;
}

std::vector<cv::Point2f> corners_in(const std::string& path) {
    GreyImage image = read_grey_image(path);
    const cv::Mat view(image.height, image.width, CV_8UC1, image.values.data());
    std::vector<cv::Point2f> corners;
    // Without CALIB_CB_NORMALIZE_IMAGE: boards far from the light are dark and flat.
    if (!cv::findChessboardCorners(view, {kBoardSide, kBoardSide}, corners,
                                   cv::CALIB_CB_ADAPTIVE_THRESH))
        return {};
    cv::cornerSubPix(view, corners, {7, 7}, {-1, -1},
                     {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 60, 1e-4});
    return corners;
}

struct Stereo {
    cv::Mat left, right, rotation, translation, fundamental;  // right <- left
    double rms_px = 0;
};

/// The corners numbered from the next corner of the board: a square board looks alike four ways.
std::vector<cv::Point2f> quarter_turned(const std::vector<cv::Point2f>& corners) {
    std::vector<cv::Point2f> out;
    for (int y = 0; y < kBoardSide; ++y)
        for (int x = 0; x < kBoardSide; ++x)
            out.push_back(corners[static_cast<std::size_t>((kBoardSide - 1 - x) * kBoardSide + y)]);
    return out;
}

/// Of the four numberings the one with the least turn between the cameras, whose true one is 23
/// deg.
std::vector<cv::Point2f> numbered_alike(const std::vector<cv::Point3f>& board,
                                        const std::vector<cv::Point2f>& left,
                                        std::vector<cv::Point2f> right, const Stereo& stereo) {
    cv::Mat left_turn, right_turn, left_matrix, right_matrix, t, turn;
    cv::solvePnP(board, left, stereo.left, cv::noArray(), left_turn, t);
    cv::Rodrigues(left_turn, left_matrix);
    std::vector<cv::Point2f> best;
    double least = 1e300;
    for (int quarter = 0; quarter < 4; ++quarter) {
        cv::solvePnP(board, right, stereo.right, cv::noArray(), right_turn, t);
        cv::Rodrigues(right_turn, right_matrix);
        cv::Rodrigues(right_matrix * left_matrix.t(), turn);
        if (cv::norm(turn) < least) {
            least = cv::norm(turn);
            best = right;
        }
        right = quarter_turned(right);
    }
    return best;
}

/// Pinhole cameras from all four boards; their relative pose from the first three, which alone are
/// of one scale.
Stereo calibrate() {
    std::vector<cv::Point3f> board;
    for (int y = 0; y < kBoardSide; ++y)
        for (int x = 0; x < kBoardSide; ++x)
            board.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.0f);
    std::vector<std::vector<cv::Point2f>> left, right;
    for (int k = 1; k <= 4; ++k) {
        left.push_back(corners_in(file_name("chessboards/c%dLeft.png", k)));
        right.push_back(corners_in(file_name("chessboards/c%dRight.png", k)));
        if (left.back().empty() || right.back().empty())
            throw std::runtime_error("no board in view " + std::to_string(k) +
                                     (left.back().empty() ? " left" : " right"));
    }
    const cv::Size size(1920, 1080);
    const int pinhole =
        cv::CALIB_ZERO_TANGENT_DIST | cv::CALIB_FIX_K1 | cv::CALIB_FIX_K2 | cv::CALIB_FIX_K3;
    Stereo out;
    cv::Mat none_left = cv::Mat::zeros(5, 1, CV_64F), none_right = none_left.clone(), essential;
    std::vector<cv::Mat> r, t;
    const std::vector<std::vector<cv::Point3f>> boards(4, board);
    cv::calibrateCamera(boards, left, size, out.left, none_left, r, t, pinhole);
    cv::calibrateCamera(boards, right, size, out.right, none_right, r, t, pinhole);
    left.resize(3);
    right.resize(3);
    for (std::size_t k = 0; k < left.size(); ++k)
        right[k] = numbered_alike(board, left[k], right[k], out);
    out.rms_px =
        cv::stereoCalibrate(std::vector<std::vector<cv::Point3f>>(3, board), left, right, out.left,
                            none_left, out.right, none_right, size, out.rotation, out.translation,
                            essential, out.fundamental, cv::CALIB_FIX_INTRINSIC);
    return out;
}

Frame load(const std::string& path) {
    const LoadedImage image = read_image(path);
    return frame_from_image(select_channel(image, ColourChannel::red), image.bits);
}

std::vector<Pulse> peaks_in(const Frame& frame, const SensorNoise& noise,
                            PeakMethod method = PeakMethod::maximum_likelihood) {
    return find_peaks(frame, noise, {.min_amplitude_dn = 60, .min_run_rows = 5, .method = method});
}

/// Places where the stripe of the right image crosses the epipolar line (a, b, c): between peaks of
/// neighbouring rows on its two sides.
std::vector<Eigen::Vector2d> crossings(const std::vector<Pulse>& peaks,
                                       const Eigen::Vector3d& line) {
    std::vector<Eigen::Vector2d> found;
    std::size_t next = 0;
    for (std::size_t i = 0; i < peaks.size(); ++i) {
        while (next < peaks.size() && peaks[next].v <= peaks[i].v) ++next;
        for (std::size_t k = next; k < peaks.size() && peaks[k].v <= peaks[i].v + 1; ++k) {
            const Eigen::Vector2d a(peaks[i].u, peaks[i].v), b(peaks[k].u, peaks[k].v);
            if (std::abs(a.x() - b.x()) > 4) continue;  // another part of the stripe
            const double da = line.dot(a.homogeneous()), db = line.dot(b.homogeneous());
            if ((da < 0) == (db < 0)) continue;
            found.push_back(a + (b - a) * (da / (da - db)));
        }
    }
    return found;
}

std::vector<Eigen::Vector3d> triangulate_frame(const Stereo& stereo, const std::vector<Pulse>& left,
                                               const std::vector<Pulse>& right) {
    std::vector<cv::Point2d> on_left, on_right;
    const cv::Matx33d f(stereo.fundamental);
    for (const Pulse& p : left) {
        const cv::Vec3d line = f * cv::Vec3d(p.u, p.v, 1);
        const auto found = crossings(right, {line[0], line[1], line[2]});
        if (found.size() != 1) continue;  // none, or not to be told apart
        on_left.emplace_back(p.u, p.v);
        on_right.emplace_back(found[0].x(), found[0].y());
    }
    if (on_left.empty()) return {};
    cv::Mat first = cv::Mat::eye(3, 4, CV_64F), second, homogeneous;
    cv::hconcat(stereo.rotation, stereo.translation, second);
    cv::triangulatePoints(cv::Mat(stereo.left * first), cv::Mat(stereo.right * second),
                          cv::Mat(on_left).reshape(1).t(), cv::Mat(on_right).reshape(1).t(),
                          homogeneous);
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < homogeneous.cols; ++i) {
        const double w = homogeneous.at<double>(3, i);
        points.emplace_back(homogeneous.at<double>(0, i) / w, homogeneous.at<double>(1, i) / w,
                            homogeneous.at<double>(2, i) / w);
    }
    return points;
}

/// Least median of squares plane by 500 seeded triples, then least squares on the nearer points.
double median_plane_residual(const std::vector<Eigen::Vector3d>& points) {
    std::mt19937 rng(1);
    std::uniform_int_distribution<std::size_t> any(0, points.size() - 1);
    double best = 1e300;
    Eigen::Vector4d plane = Eigen::Vector4d::Zero();
    const auto residuals = [&](const Eigen::Vector4d& p) {
        std::vector<double> r;
        for (const Eigen::Vector3d& at : points) r.push_back(std::abs(p.dot(at.homogeneous())));
        return r;
    };
    for (int trial = 0; trial < 500; ++trial) {
        const Eigen::Vector3d a = points[any(rng)], b = points[any(rng)], c = points[any(rng)];
        const Eigen::Vector3d normal = (b - a).cross(c - a);
        if (normal.norm() < 1e-9) continue;
        const Eigen::Vector3d n = normal.normalized();
        const Eigen::Vector4d candidate(n.x(), n.y(), n.z(), -n.dot(a));
        const double m = median(residuals(candidate));
        if (m < best) {
            best = m;
            plane = candidate;
        }
    }
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    std::vector<Eigen::Vector3d> near;
    for (const Eigen::Vector3d& p : points)
        if (std::abs(plane.dot(p.homogeneous())) < 4 * best + 1e-6) near.push_back(p);
    for (const Eigen::Vector3d& p : near) mean += p / static_cast<double>(near.size());
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& p : near) scatter += (p - mean) * (p - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
    const Eigen::Vector3d n = solver.eigenvectors().col(0);
    return median(residuals({n.x(), n.y(), n.z(), -n.dot(mean)}));
}

TEST(StereoStripe, PeaksOfEachFrameLieInOnePlane) {
    if (data_folder().empty())
        GTEST_SKIP() << "set STRIA_TEST_DATA to the folder of real data sets";
    const Stereo stereo = calibrate();
    std::printf("stereo rms %.3f px, T = (%.3f %.3f %.3f) squares\n", stereo.rms_px,
                stereo.translation.at<double>(0), stereo.translation.at<double>(1),
                stereo.translation.at<double>(2));
    int good = 0, points_in_all = 0;
    SensorNoise noise;
    for (int k = kFirst; k <= kLast; ++k) {
        const Frame left = load(file_name("scanLeft/%04d.png", k));
        const Frame right = load(file_name("scanRight/scan%04d.png", k));
        if (k == kFirst) noise = estimate_noise({&left, 1});
        const auto points =
            triangulate_frame(stereo, peaks_in(left, noise), peaks_in(right, noise));
        if (points.size() < 10) continue;
        const double residual = median_plane_residual(points);
        std::printf("frame %2d: %4zu points, median plane residual %.5f squares\n", k,
                    points.size(), residual);
        good += residual <= 0.002;
        points_in_all += static_cast<int>(points.size());
    }
    std::printf("%d points, %d of %d frames within 0.002 squares\n", points_in_all, good,
                kLast - kFirst + 1);
    EXPECT_GE(good, 19);
    EXPECT_GE(points_in_all, 6000);  // of about 7000 peaks: the rest is occluded in the other view
}

/// What the methods differ by: the flatness of the sheet as each sees it, over the same frames.
TEST(StereoStripe, PeaksOfEveryMethodLieInOnePlane) {
    if (data_folder().empty())
        GTEST_SKIP() << "set STRIA_TEST_DATA to the folder of real data sets";
    const Stereo stereo = calibrate();
    std::vector<Frame> left, right;
    for (int k = kFirst; k <= kLast; ++k) {
        left.push_back(load(file_name("scanLeft/%04d.png", k)));
        right.push_back(load(file_name("scanRight/scan%04d.png", k)));
    }
    const SensorNoise noise = estimate_noise({left.data(), 1});
    std::printf("%-12s  frames within 0.002  points  median residual, squares\n", "method");
    for (const PeakMethod method : kPeakMethods) {
        std::vector<double> of_frames;
        std::size_t points_in_all = 0;
        for (std::size_t i = 0; i < left.size(); ++i) {
            const auto points = triangulate_frame(stereo, peaks_in(left[i], noise, method),
                                                  peaks_in(right[i], noise, method));
            if (points.size() < 10) continue;
            of_frames.push_back(median_plane_residual(points));
            points_in_all += points.size();
        }
        const auto good = std::count_if(of_frames.begin(), of_frames.end(),
                                        [](double residual) { return residual <= 0.002; });
        std::printf("%-12s %20d %7zu %.5f\n", name_of(method).data(), static_cast<int>(good),
                    points_in_all, median(of_frames));
        EXPECT_GE(good, 19) << name_of(method);
        EXPECT_GE(points_in_all, 6000u) << name_of(method);
    }
}

TEST(StereoStripe, SweepIsRecognisedAsUndersampled) {
    if (data_folder().empty())
        GTEST_SKIP() << "set STRIA_TEST_DATA to the folder of real data sets";
    Frame first = load(file_name("scanLeft/%04d.png", 0));
    SpacetimeAnalyser analyser(first.width, first.height, first.bits, estimate_noise({&first, 1}));
    for (int k = 0; k < 26; ++k) {
        Frame frame = load(file_name("scanLeft/%04d.png", k));
        frame.sequence = static_cast<std::uint32_t>(k);
        frame.exposure_start_ns = k * kNsPerSecond;
        analyser.add(frame);
    }
    const PulseMap map = analyser.finish();
    EXPECT_TRUE(map.undersampled);
    EXPECT_TRUE(map.pulses.empty());
    EXPECT_GT(analyser.sampling().step_px, 20 * analyser.sampling().width_px);
}

}  // namespace
}  // namespace stria
