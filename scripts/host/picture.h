// Figures to files.

#pragma once

#include <string>

#include "render/figure.h"
#include "scripts/host/session.h"

namespace plantloop::lua {

// Draws the figure into a file below the working directory, in the format of its ending; returns the path. Throws
// ScriptError when it cannot.
std::string save_picture(const Session& session, const Figure& figure, const std::string& path);

}  // namespace plantloop::lua
