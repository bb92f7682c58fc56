// Things in three dimensions: surfaces over a grid, curves and points, seen from afar (parallel projection).

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/color.h"

namespace plantloop {

// z over the grid of x and y; z[i * x.size() + k] belongs to x[k], y[i]. Facets with a corner that is not finite are
// left out.
struct Surface {
  std::vector<double> x, y, z;
  bool filled = true;  // else a wireframe
  std::string label;
};

// A curve, or points when `line` is false.
struct SpaceCurve {
  std::vector<double> x, y, z;
  std::string label;
  bool line = true;
};

struct SpaceAxis {
  std::string label;
  std::optional<double> lower, upper;
};

struct Space {
  SpaceAxis x, y, z;
  std::vector<Surface> surfaces;
  std::vector<SpaceCurve> curves;
  double azimuth = -50;   // degrees the eye is turned about the z axis, from the negative y axis
  double elevation = 28;  // degrees of the eye above the x-y plane
};

}  // namespace plantloop
