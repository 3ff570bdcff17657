#include <ctime>
#include <exception>
#include <iostream>
#include <opencv2/calib3d.hpp>

#include "calib/scanner_calibration.h"
#include "tests/calib/synthetic_scanner.h"

/// The joint solve of a scanner with 100 views of a board, beside OpenCV's calibration of the
/// camera alone on the same corners: CPU seconds and their ratio. Goal: 10.
namespace stria {
namespace {

/// CPU seconds of a call: both sides are judged by work, not by how busy the machine is.
template <typename Call>
double cpu_seconds(const Call& call) {
    const std::clock_t start = std::clock();
    call();
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

struct CameraCorners {
    std::vector<std::vector<cv::Point3f>> on_board;
    std::vector<std::vector<cv::Point2f>> in_image;
};

CameraCorners corners_of(const std::vector<CornerView>& views, const Board& board) {
    const auto points = board_points(board);
    CameraCorners corners;
    for (const CornerView& view : views)
        for (const BoardCorners& seen : view.corners) {
            corners.on_board.emplace_back();
            corners.in_image.emplace_back();
            for (std::size_t i = 0; i < seen.ids.size(); ++i) {
                const Eigen::Vector3f p =
                    points[static_cast<std::size_t>(seen.ids[i])].cast<float>();
                const Eigen::Vector2f pixel = seen.pixels[i].cast<float>();
                corners.on_board.back().emplace_back(p.x(), p.y(), 0.F);
                corners.in_image.back().emplace_back(pixel.x(), pixel.y());
            }
        }
    return corners;
}

double opencv_seconds(const CameraCorners& corners, const CameraModel& drawn) {
    cv::Mat k, distortion, r, t;
    double rms_px = 0;
    const double seconds = cpu_seconds([&] {
        rms_px = cv::calibrateCamera(corners.on_board, corners.in_image,
                                     cv::Size(drawn.width, drawn.height), k, distortion, r, t);
    });
    std::cout << ", OpenCV's camera " << seconds << " s (" << corners.in_image.size()
              << " pictures, rms " << rms_px << " px)";
    return seconds;
}

void compare(MachineKind kind) {
    const Board board = parse_board("chessboard:12x9:22");
    const ScannerModel drawn = drawn_scanner(kind);
    std::mt19937 rng(71);
    const ScannerModel truth = built_scanner(drawn, rng);
    SyntheticOptions options;
    options.views = 100;
    options.pixel_step = 16;
    const auto views = synthetic_views(truth, board, options, rng);
    std::cout << name_of(kind) << ", 100 views, CPU";
    const double opencv = opencv_seconds(corners_of(views, board), drawn.channels[0].camera);
    ScannerCalibration found;
    const double ours = cpu_seconds([&] { found = calibrate_scanner(views, board, drawn); });
    std::cout << ", the joint solve " << ours << " s (rms " << found.rms_px << " px, "
              << (found.converged ? "converged" : "not converged") << "): " << ours / opencv
              << " times" << std::endl;
}

}  // namespace
}  // namespace stria

int main() {
    try {
        for (const stria::MachineKind kind :
             {stria::MachineKind::swept, stria::MachineKind::rail, stria::MachineKind::turntable})
            stria::compare(kind);
    } catch (const std::exception& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
    return 0;
}
