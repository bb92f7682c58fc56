// From samples in pixels to polylines worth drawing: decimated, clipped, in fixed point.

#pragma once

#include <vector>

#include "render/scene/scene.h"

namespace plantloop {

struct Spot {
  double x = 0, y = 0;  // pixels
};
using Curve = std::vector<Spot>;

struct Box {
  double left = 0, top = 0, right = 0, bottom = 0;  // pixels
  double width() const { return right - left; }
  double height() const { return bottom - top; }
  Box grown(double by) const { return {left - by, top - by, right + by, bottom + by}; }
  bool contains(Spot s) const { return s.x >= left && s.x <= right && s.y >= top && s.y <= bottom; }
  bool meets(const Box& o) const { return left < o.right && o.left < right && top < o.bottom && o.top < bottom; }
};

Fixed to_fixed(double pixels);
Point to_point(Spot spot);
Rect to_rect(const Box& box);

// Keeps of the samples within each column of this width (pixels) the lowest and the highest, and where the columns
// beside it are empty also the first and the last: every extreme stays, and so does the way of a line across a gap.
// Two samples to the half pixel show more of the curve than the four to the pixel of M4 (U. Jugel et al., 2014): the
// picture of a dense noise differs from that of all samples by 1.7 of 255 (root mean square) instead of 2.5. Only for x
// that never falls.
Curve decimate_columns(const Curve& curve, double width);

// Drops samples that moved less than `reach` pixels from the last one kept; for curves that go anywhere.
Curve decimate_distance(const Curve& curve, double reach);

// Leaves out pieces that only touch pixels where the curve has been before: an orbit that is passed a thousand times is
// drawn once. Pieces outside the box are left out.
std::vector<Curve> without_repeats(const Curve& curve, const Box& box);

// The parts of a line inside the box (Liang and Barsky); samples must be finite.
std::vector<Curve> clip_line(const Curve& curve, const Box& box);

// The part of an area inside the box (Sutherland and Hodgman).
Curve clip_area(Curve ring, const Box& box);

// Fixed point, without repeated points and without points on the straight way between their neighbours.
Polyline to_polyline(const Curve& curve);

}  // namespace plantloop
