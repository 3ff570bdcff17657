#pragma once
#include <opencv2/aruco/charuco.hpp>
#include <string>
#include <vector>

#include "host/core/board.h"

/// Markers of ChArUco boards, and whose board they are. For calib's own .cpp files only.
namespace stria {

struct Markers {
    std::vector<int> ids;
    std::vector<std::vector<cv::Point2f>> corners;
};

Markers find_markers(const cv::Mat& image, const cv::Ptr<cv::aruco::Dictionary>& dictionary);

/// The markers with ids below `count`: those that a board of so many markers can have.
Markers with_ids_below(const Markers& markers, int count);

/// Share of the markers whose corners one homography of the board explains, to a quarter of their
/// side. Every id must be on the board.
double explained_share(const cv::aruco::CharucoBoard& board, const Markers& markers);

/// "wrong board: ..." if the markers (those of the board's dictionary in that picture) belong to
/// another board: columns and rows swapped, another number of either, another dictionary, each by
/// name; empty if they fit, or if there is no marker at all. A few markers that are none (clutter
/// that looks like one) do not matter.
std::string wrong_charuco(const cv::Mat& image, const Board& board, const Markers& markers);

}  // namespace stria
