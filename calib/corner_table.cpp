#include "calib/corner_table.h"

#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "host/core/errors.h"
#include "host/io/whole_file.h"

namespace stria {

std::vector<CameraView> read_corner_table(const std::string& path, const Board& board) {
    const bool charuco = board.kind == BoardKind::charuco;
    const int columns = board.columns - (charuco ? 1 : 0), rows = board.rows - (charuco ? 1 : 0);
    std::istringstream in(read_whole_file(path, std::size_t{1} << 30));
    std::map<std::string, std::size_t> index;
    std::set<std::pair<std::size_t, int>> seen;
    std::vector<CameraView> views;
    std::string line;
    for (int number = 1; std::getline(in, line); ++number) {
        const auto refuse = [&](const std::string& why) {
            throw FileError(path, "line " + std::to_string(number), why);
        };
        line = line.substr(0, line.find('#'));
        std::istringstream fields(line);
        std::string view, extra;
        if (!(fields >> view)) continue;
        int row = 0, column = 0;
        double x = 0, y = 0, weight = 1;
        if (!(fields >> row >> column >> x >> y))
            refuse("expected \"view row col x y weight\", found \"" + line + "\"");
        if (!(fields >> weight)) {
            if (!fields.eof()) refuse("weight is no number in \"" + line + "\"");
            weight = 1;
        }
        if (fields.clear(), fields >> extra) refuse("\"" + extra + "\" follows the weight");
        if (row < 0 || row >= rows || column < 0 || column >= columns)
            refuse("row " + std::to_string(row) + ", col " + std::to_string(column) +
                   ": the board has rows 0 to " + std::to_string(rows - 1) + " and cols 0 to " +
                   std::to_string(columns - 1));
        if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(weight))
            refuse("expected finite numbers");
        const auto [place, is_new] = index.try_emplace(view, views.size());
        if (is_new) views.push_back({"view " + view, {}, {}, {}});
        const int id = row * columns + column;
        if (!seen.insert({place->second, id}).second)
            refuse("row " + std::to_string(row) + ", col " + std::to_string(column) + " of view " +
                   view + " comes twice");
        CameraView& target = views[place->second];
        target.ids.push_back(id);
        target.pixels.emplace_back(x, y);
        target.weights.push_back(weight);
    }
    if (views.empty())
        throw FileError(path, "", "expected lines \"view row col x y weight\", found none");
    return views;
}

}  // namespace stria
