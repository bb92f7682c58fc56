// Arrangement -> scene.

#pragma once

#include <string_view>

#include "render/diagram/arrangement.h"
#include "render/scene/scene.h"

namespace plantloop {

// The sheet as a scene at 152.4 dpi, as large as it needs to be. Throws RenderError for an unknown theme and for a
// sheet that needs more than 16384 pixels.
Scene draw(const Sheet& sheet, const Arrangement& arrangement, std::string_view theme = "light");

}  // namespace plantloop
