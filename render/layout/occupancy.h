// Where in a panel there is something to see: a coarse map for placing labels in free space.

#pragma once

#include <cstdint>
#include <vector>

#include "render/geometry/curve.h"

namespace plantloop {

class Occupancy {
 public:
  Occupancy(const Box& box, double cell);

  void add_line(const Curve& curve);
  void add_area(const Curve& ring);
  void add_box(const Box& box, int weight);

  // The weight of what the box covers; parts outside the panel count as full.
  double covered(const Box& box) const;

 private:
  static constexpr int line_weight = 8;
  void mark(int column, int row, int weight);

  Box box_;
  double cell_;
  int columns_, rows_;
  std::vector<std::uint8_t> cells_;
};

}  // namespace plantloop
