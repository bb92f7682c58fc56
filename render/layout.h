// Figure -> scene. A pure function: no files, no globals, no clock; equal figures give equal scenes.

#pragma once

#include "render/figure.h"
#include "render/scene/scene.h"

namespace plantloop {

// Throws RenderError for an unknown theme or a size that cannot be drawn (below 20 mm, above 16384 pixels). Any data
// are accepted: what is not finite, or not positive on a logarithmic axis, interrupts the line.
Scene layout(const Figure& figure);

}  // namespace plantloop
