#pragma once
#include <string>

#include "host/report/report.h"

namespace stria {

/// Markup of a mesh to turn: a picture of it, and over it a canvas with the mesh's numbers inlined
/// for the viewer's script. `id` must be unique on the page.
std::string mesh_viewer_html(const ReportMesh& mesh, const std::string& id);

}  // namespace stria
