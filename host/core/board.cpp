#include "host/core/board.h"

#include <charconv>
#include <cmath>
#include <sstream>

#include "host/core/errors.h"

namespace stria {
namespace {

const char* const kKinds[] = {"chessboard", "charuco", "circles", "acircles"};

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
    throw Error("board \"" + text + "\": " + why +
                "; expected chessboard:COLSxROWS:SQUARE_MM, "
                "charuco:COLSxROWS:SQUARE_MM:MARKER_MM:DICT, circles:COLSxROWS:PITCH_MM or "
                "acircles:COLSxROWS:PITCH_MM");
}

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
    return parts;
}

template <typename T>
std::optional<T> number(const std::string& text) {
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

std::string short_number(double value) {
    std::ostringstream out;
    out << value;
    return out.str();
}

}  // namespace

Board parse_board(const std::string& text) {
    const auto parts = split(text, ':');
    Board board;
    int kind = -1;
    for (int i = 0; i < 4; ++i)
        if (!parts.empty() && parts[0] == kKinds[i]) kind = i;
    if (kind < 0) refuse(text, "unknown kind \"" + (parts.empty() ? "" : parts[0]) + "\"");
    board.kind = static_cast<BoardKind>(kind);
    const std::size_t expected = board.kind == BoardKind::charuco ? 5 : 3;
    if (parts.size() != expected)
        refuse(text, "has " + std::to_string(parts.size()) + " parts instead of " +
                         std::to_string(expected));
    const auto counts = split(parts[1], 'x');
    const auto columns = counts.size() == 2 ? number<int>(counts[0]) : std::nullopt;
    const auto rows = counts.size() == 2 ? number<int>(counts[1]) : std::nullopt;
    if (!columns || !rows || *columns < 2 || *rows < 2 || *columns > 200 || *rows > 200)
        refuse(text, "\"" + parts[1] + "\" is not COLSxROWS with 2 to 200 each");
    board.columns = *columns;
    board.rows = *rows;
    const auto pitch = number<double>(parts[2]);
    if (!pitch || !(*pitch > 0 && *pitch < 1e5))
        refuse(text, "\"" + parts[2] + "\" is no length in mm");
    board.pitch_mm = *pitch;
    if (board.kind == BoardKind::charuco) {
        const auto marker = number<double>(parts[3]);
        if (!marker || !(*marker > 0 && *marker < board.pitch_mm))
            refuse(text, "\"" + parts[3] + "\" is no marker side in mm below the square's");
        board.marker_mm = *marker;
        board.dictionary = parts[4];
        if (board.dictionary.rfind("DICT_", 0) != 0)
            refuse(text, "\"" + parts[4] + "\" is no dictionary such as DICT_6X6_250");
    }
    return board;
}

std::string to_string(const Board& board) {
    std::string text = std::string(kKinds[static_cast<int>(board.kind)]) + ":" +
                       std::to_string(board.columns) + "x" + std::to_string(board.rows) + ":" +
                       short_number(board.pitch_mm);
    if (board.kind == BoardKind::charuco)
        text += ":" + short_number(board.marker_mm) + ":" + board.dictionary;
    return text;
}

std::vector<Eigen::Vector3d> board_points(const Board& board) {
    std::vector<Eigen::Vector3d> points;
    const bool charuco = board.kind == BoardKind::charuco;
    const int columns = charuco ? board.columns - 1 : board.columns;
    const int rows = charuco ? board.rows - 1 : board.rows;
    const double first = charuco ? board.pitch_mm : 0.0;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const double x = board.kind == BoardKind::acircles
                                 ? (2 * column + row % 2) * board.pitch_mm
                                 : first + column * board.pitch_mm;
            points.emplace_back(x, first + row * board.pitch_mm, 0.0);
        }
    if (!board.warp_mm.isZero()) {
        const BoardRise rise(points);
        for (Eigen::Vector3d& p : points) p.z() = rise.at(p.head<2>()).dot(board.warp_mm);
    }
    return points;
}

Board with_warp(Board board, const Eigen::Vector2d& warp_mm) {
    board.warp_mm = warp_mm;
    return board;
}

BoardRise::BoardRise(const std::vector<Eigen::Vector3d>& points) {
    Eigen::Vector2d low = points.front().head<2>(), high = low;
    for (const Eigen::Vector3d& p : points) {
        low = low.cwiseMin(p.head<2>());
        high = high.cwiseMax(p.head<2>());
    }
    middle_ = 0.5 * (low + high);
    half_ = 0.5 * (high - low);
}

Eigen::Vector2d BoardRise::at(const Eigen::Vector2d& on_board) const {
    return 1 - (on_board - middle_).cwiseQuotient(half_).array().square();
}

Eigen::Vector2d pattern_size_mm(const Board& board) {
    switch (board.kind) {
        case BoardKind::chessboard:
            return board.pitch_mm * Eigen::Vector2d(board.columns + 1, board.rows + 1);
        case BoardKind::charuco:
            return board.pitch_mm * Eigen::Vector2d(board.columns, board.rows);
        case BoardKind::circles:
            return board.pitch_mm * Eigen::Vector2d(board.columns, board.rows);
        case BoardKind::acircles:
            return board.pitch_mm * Eigen::Vector2d(2 * board.columns, board.rows);
    }
    return {};
}

}  // namespace stria
