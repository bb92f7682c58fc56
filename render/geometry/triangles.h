// Scenes as triangles. Every corner is rounded to 1/256 pixel, so that the last bits of a square root never show.

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "render/scene/scene.h"

namespace plantloop {

// Triangles of one colour.
struct Batch {
  enum class Kind {
    direct,   // opaque: triangles may overlap
    winding,  // triangles whose winding numbers tell inside from outside
    mask,     // translucent strokes: every point that any triangle covers counts once
  };
  Kind kind = Kind::direct;
  Color color;
  std::optional<Rect> clip;
  // Boxes that together hold all triangles: one to the text or ring, so that little else is looked at when the inside
  // is coloured.
  std::vector<Rect> covers;
  // Parts of the list of corners, each with the height it covers, so that a strip of the picture skips the others.
  struct Part {
    std::int32_t first = 0, count = 0;
    Fixed top = 0, bottom = 0;
  };
  std::vector<Part> parts;
};

struct Triangles {
  std::vector<Point> corners;  // three to the triangle
  std::vector<Batch> batches;  // in the order of drawing
};

Triangles triangulate(const Scene& scene);

}  // namespace plantloop
