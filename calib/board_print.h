#pragma once
#include <string>

#include "host/core/board.h"

namespace stria {

/// The board as a one-page PDF (1.4) or an SVG document at true scale: black vector shapes, 12 mm
/// of white all round, below it the board's text and a 100 mm ruler (50 mm on narrow boards) to
/// check the print's scale with. The page is as large as board and margins need. Throws
/// stria::Error as board_shapes() does, and for boards larger than 5 m (a PDF page's limit).
std::string board_pdf(const Board& board);
std::string board_svg(const Board& board);

}  // namespace stria
