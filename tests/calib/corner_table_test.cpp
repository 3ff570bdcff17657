#include "calib/corner_table.h"

#include <gtest/gtest.h>

#include <fstream>

#include "host/core/errors.h"

namespace stria {
namespace {

std::string file_with(const std::string& text) {
    const std::string path =
        testing::TempDir() + "/corners_" + std::to_string(std::hash<std::string>{}(text)) + ".txt";
    std::ofstream(path) << text;
    return path;
}

TEST(CornerTable, ReadsViewsInTheOrderTheyAppear) {
    const Board board = parse_board("chessboard:4x3:10");
    const auto views = read_corner_table(
        file_with("# view row col x y weight\nb 0 1 10.5 20 1\n\na 2 3 1 2 0.5 # far\nb 1 0 3 4\n"),
        board);
    ASSERT_EQ(views.size(), 2u);
    EXPECT_EQ(views[0].name, "view b");
    EXPECT_EQ(views[0].ids, (std::vector<int>{1, 4}));
    EXPECT_EQ(views[0].weights, (std::vector<double>{1, 1}));
    EXPECT_EQ(views[1].ids, std::vector<int>{11});
    EXPECT_EQ(views[1].pixels[0], Eigen::Vector2d(1, 2));
    EXPECT_EQ(views[1].weights[0], 0.5);
}

TEST(CornerTable, NamesTheLineThatIsWrong) {
    const Board board = parse_board("chessboard:4x3:10");
    for (const char* bad :
         {"a 0 0 1", "a 3 0 1 2 1", "a 0 4 1 2 1", "a 0 0 1 nan 1", "a 0 0 1 2 1 extra",
          "a 0 0 1 2 x", "a 0.5 0 1 2 1", "a 0 0 1 2 1\na 0 0 1 2 1"}) {
        try {
            read_corner_table(file_with(std::string("# head\n") + bad + "\n"), board);
            ADD_FAILURE() << bad;
        } catch (const FileError& error) {
            EXPECT_NE(std::string(error.what()).find("line "), std::string::npos) << error.what();
        }
    }
    EXPECT_THROW(read_corner_table(file_with("# nothing\n"), board), FileError);
    EXPECT_THROW(read_corner_table("/no/such/file", board), FileError);
}

}  // namespace
}  // namespace stria
