// What draws a scene into one format. To add a format add render/backend/<format>.cpp with `const Backend
// backend_<format>`; the list of all is made from the names of the files.

#pragma once

#include <cstdint>
#include <vector>

#include "render/scene/scene.h"

namespace plantloop {

struct Backend {
  const char* format;
  std::vector<std::uint8_t> (*draw)(const Scene&);
};

}  // namespace plantloop
