#include "calib/board_print.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "calib/board_shapes.h"
#include "host/core/errors.h"

namespace stria {
namespace {

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t n = 0;
    for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
    return n;
}

TEST(BoardPrint, HoldsEveryShapeAtTrueScale) {
    const Board board = parse_board("charuco:7x5:20:10:DICT_6X6_250");
    const std::string svg = board_svg(board), pdf = board_pdf(board);
    const std::size_t shapes = board_shapes(board).rects.size();
    const std::size_t ruler = 1 + 11;                    // line, and a tick every 10 mm of 100
    EXPECT_EQ(count(svg, "<rect"), 1 + shapes + ruler);  // and the paper
    EXPECT_EQ(count(pdf, " re f\n"), shapes + ruler);
    // 140 x 100 mm, 12 mm margins, 16 mm below for ruler and text
    EXPECT_NE(svg.find("width=\"164mm\" height=\"140mm\" viewBox=\"0 0 164 140\""),
              std::string::npos);
    // 72 points an inch: 164 mm are 464.88189 points
    EXPECT_NE(pdf.find("/MediaBox [0 0 464.88189 396.85039]"), std::string::npos);
    // square 0: upper left corner 12 mm from the paper's, 56.69291 points wide
    EXPECT_NE(pdf.find("34.01575 306.14173 56.69291 56.69291 re f"), std::string::npos);
    EXPECT_NE(pdf.find(to_string(board)), std::string::npos);
}

TEST(BoardPrint, PointsItsCrossReferenceTableAtTheObjects) {
    const std::string pdf = board_pdf(parse_board("circles:5x4:15"));
    EXPECT_EQ(count(pdf, "c f\n"), 20u);
    const auto start = pdf.rfind("startxref\n");
    const auto table = std::stoul(pdf.substr(start + 10));
    ASSERT_EQ(pdf.compare(table, 4, "xref"), 0);
    for (int i = 1; i <= 5; ++i) {
        const auto entry = table + std::string("xref\n0 6\n").size() + 20 * std::size_t(i);
        const auto offset = std::stoul(pdf.substr(entry, 10));
        const std::string head = std::to_string(i) + " 0 obj\n";
        EXPECT_EQ(pdf.compare(offset, head.size(), head), 0) << "object " << i;
    }
    const auto length = pdf.find("/Length ");
    const auto bytes = std::stoul(pdf.substr(length + 8));
    const auto stream = pdf.find("stream\n", length) + 7;
    EXPECT_EQ(pdf.compare(stream + bytes, 9, "endstream"), 0);
}

TEST(BoardPrint, RefusesWhatNoPageHolds) {
    EXPECT_THROW(board_pdf(parse_board("chessboard:100x100:60")), Error);
    EXPECT_THROW(board_svg(parse_board("charuco:7x5:20:10:DICT_6X6_9")), Error);
}

}  // namespace
}  // namespace stria
