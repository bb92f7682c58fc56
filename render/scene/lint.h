// Faults that can be found without looking at pixels.

#pragma once

#include <string>
#include <vector>

#include "render/scene/scene.h"

namespace plantloop {

// One line for each fault; empty for a sound scene. Looked for: text outside the picture, texts that overlap, too
// little contrast of text (4.5) or of thin strokes (3), numbers at the axes that are not evenly spaced, not in order,
// or do not say what their place means, labels of series without entry in the key, empty paths, coordinates far
// outside.
std::vector<std::string> lint(const Scene& scene);

}  // namespace plantloop
