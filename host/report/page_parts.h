#pragma once

namespace stria {

/// Style sheet of the page: light and dark by the reader's setting.
extern const char* const kPageStyle;

/// Script that turns every <canvas data-mesh> into a viewer: drag turns, wheel zooms, double click
/// resets. WebGL 2 without outside code; the picture below the canvas stays where there is none.
extern const char* const kViewerScript;

}  // namespace stria
