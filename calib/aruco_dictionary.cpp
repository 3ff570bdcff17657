#include "calib/aruco_dictionary.h"

#include <utility>

#include "host/core/errors.h"

namespace stria {
namespace {

using Entry = std::pair<const char*, cv::aruco::PREDEFINED_DICTIONARY_NAME>;

const Entry kDictionaries[] = {
    {"DICT_4X4_50", cv::aruco::DICT_4X4_50},
    {"DICT_4X4_100", cv::aruco::DICT_4X4_100},
    {"DICT_4X4_250", cv::aruco::DICT_4X4_250},
    {"DICT_4X4_1000", cv::aruco::DICT_4X4_1000},
    {"DICT_5X5_50", cv::aruco::DICT_5X5_50},
    {"DICT_5X5_100", cv::aruco::DICT_5X5_100},
    {"DICT_5X5_250", cv::aruco::DICT_5X5_250},
    {"DICT_5X5_1000", cv::aruco::DICT_5X5_1000},
    {"DICT_6X6_50", cv::aruco::DICT_6X6_50},
    {"DICT_6X6_100", cv::aruco::DICT_6X6_100},
    {"DICT_6X6_250", cv::aruco::DICT_6X6_250},
    {"DICT_6X6_1000", cv::aruco::DICT_6X6_1000},
    {"DICT_7X7_50", cv::aruco::DICT_7X7_50},
    {"DICT_7X7_100", cv::aruco::DICT_7X7_100},
    {"DICT_7X7_250", cv::aruco::DICT_7X7_250},
    {"DICT_7X7_1000", cv::aruco::DICT_7X7_1000},
    {"DICT_ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL},
};

}  // namespace

cv::Ptr<cv::aruco::Dictionary> aruco_dictionary(const std::string& name) {
    std::string known;
    for (const auto& [text, id] : kDictionaries) {
        if (name == text) return cv::aruco::getPredefinedDictionary(id);
        known += known.empty() ? text : std::string(", ") + text;
    }
    throw Error("dictionary \"" + name + "\" is unknown; expected one of " + known);
}

cv::Ptr<cv::aruco::CharucoBoard> charuco_board(const Board& board) {
    const auto dictionary = aruco_dictionary(board.dictionary);
    const int markers = board.columns * board.rows / 2;
    if (markers > dictionary->bytesList.rows)
        throw Error("board " + to_string(board) + " needs " + std::to_string(markers) +
                    " markers, but " + board.dictionary + " has " +
                    std::to_string(dictionary->bytesList.rows));
    return cv::aruco::CharucoBoard::create(board.columns, board.rows,
                                           static_cast<float>(board.pitch_mm),
                                           static_cast<float>(board.marker_mm), dictionary);
}

}  // namespace stria
