// Lines of equal height over a grid, and the areas above them.

#pragma once

#include <vector>

namespace plantloop {

struct Path {
  std::vector<double> x, y;
};

// z over x and y: z[row * x.size() + column]. Heights between the corners of a cell are linear along its edges; the
// ambiguous cell of two opposite corners is decided by its mean. Cells with a corner that is not finite are left out.
struct HeightField {
  std::vector<double> x, y, z;
};

// The lines on which the field has this height, joined from cell to cell.
std::vector<Path> contour_lines(const HeightField& field, double level);

// Polygons, one to four to the cell row, that together cover where the field is at least as high.
std::vector<Path> area_above(const HeightField& field, double level);

// Heights to draw lines at, nice numbers, about `count`, strictly between the least and the greatest finite value.
std::vector<double> nice_levels(const std::vector<double>& z, int count);

}  // namespace plantloop
