#include "calib/detect_board.h"

#include <stdexcept>

#include "calib/detect_charuco.h"
#include "calib/detect_grid.h"

namespace stria {
namespace {

/// OpenCV's detectors draw from the thread's generator: started anew for every picture, so that
/// what they find does not depend on what was looked at before. The caller's comes back afterwards.
class FreshRandomNumbers {
  public:
    FreshRandomNumbers() { cv::theRNG() = cv::RNG(1); }
    ~FreshRandomNumbers() { cv::theRNG() = before_; }
    FreshRandomNumbers(const FreshRandomNumbers&) = delete;
    FreshRandomNumbers& operator=(const FreshRandomNumbers&) = delete;

  private:
    cv::RNG before_ = cv::theRNG();
};

}  // namespace

Detection detect_board(const GreyImage& image, const Board& board) {
    if (image.empty() || image.channels != 1)
        throw std::invalid_argument("image: expected one channel and at least one pixel, found " +
                                    std::to_string(image.width) + " x " +
                                    std::to_string(image.height) + " x " +
                                    std::to_string(image.channels));
    // OpenCV only reads through the pointer.
    const cv::Mat pixels(image.height, image.width, CV_8UC1,
                         const_cast<std::uint8_t*>(image.values.data()));
    const FreshRandomNumbers numbers;
    switch (board.kind) {
        case BoardKind::chessboard:
            return detect_chessboard(pixels, board);
        case BoardKind::charuco:
            return detect_charuco(pixels, board);
        case BoardKind::circles:
        case BoardKind::acircles:
            return detect_circles(pixels, board);
    }
    return {};
}

bool looks_same_turned(const Board& board) {
    if (board.kind == BoardKind::circles) return true;
    if (board.kind == BoardKind::acircles) return board.rows % 2 == 0;
    return board.kind == BoardKind::chessboard && (board.columns + board.rows) % 2 == 0;
}

}  // namespace stria
