// Marching squares (W. Lorensen, H. Cline, 1987, in two dimensions).

#include "render/numbers/contours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "render/layout/ticks.h"

namespace plantloop {
namespace {

struct Corner {
  double x = 0, y = 0, z = 0;
};

// An edge of the grid: below or left of the point `index`.
using Edge = std::pair<std::size_t, bool>;
struct Segment {
  Edge from, to;
};

class Cells {
 public:
  explicit Cells(const HeightField& f) : f_(f), columns_(f.x.size()), rows_(f.y.size()) {
    if (f.z.size() < columns_ * rows_) rows_ = 0;
  }
  std::size_t columns() const { return columns_ < 2 ? 0 : columns_ - 1; }
  std::size_t rows() const { return rows_ < 2 ? 0 : rows_ - 1; }
  Corner corner(std::size_t row, std::size_t column) const {
    return {f_.x[column], f_.y[row], f_.z[row * columns_ + column]};
  }
  // Anticlockwise from the lower left.
  std::array<Corner, 4> cell(std::size_t row, std::size_t column) const {
    return {corner(row, column), corner(row, column + 1), corner(row + 1, column + 1), corner(row + 1, column)};
  }
  std::array<Edge, 4> edges(std::size_t row, std::size_t column) const {
    const auto point = [&](std::size_t r, std::size_t c) { return r * columns_ + c; };
    return {Edge{point(row, column), false}, Edge{point(row, column + 1), true}, Edge{point(row + 1, column), false},
            Edge{point(row, column), true}};
  }
  // The point of an edge at the level.
  Corner on(Edge edge, double level) const {
    const std::size_t row = edge.first / columns_, column = edge.first % columns_;
    const Corner a = corner(row, column), b = edge.second ? corner(row + 1, column) : corner(row, column + 1);
    const double t = std::clamp((level - a.z) / (b.z - a.z), 0.0, 1.0);
    return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), level};
  }

 private:
  const HeightField& f_;
  std::size_t columns_, rows_;
};

bool finite(const std::array<Corner, 4>& cell) {
  return std::all_of(cell.begin(), cell.end(),
                     [](const Corner& c) { return std::isfinite(c.x) && std::isfinite(c.y) && std::isfinite(c.z); });
}

// The pieces of the line in one cell, from edge to edge.
std::vector<Segment> segments(const Cells& cells, std::size_t row, std::size_t column, double level) {
  const std::array<Corner, 4> c = cells.cell(row, column);
  if (!finite(c)) return {};
  const std::array<Edge, 4> e = cells.edges(row, column);
  int pattern = 0;
  for (int i = 0; i < 4; ++i) pattern |= (c[static_cast<std::size_t>(i)].z >= level) << i;
  const bool middle = (c[0].z + c[1].z + c[2].z + c[3].z) / 4 >= level;
  switch (pattern) {
    case 1:
    case 14:
      return {{e[3], e[0]}};
    case 2:
    case 13:
      return {{e[0], e[1]}};
    case 4:
    case 11:
      return {{e[1], e[2]}};
    case 8:
    case 7:
      return {{e[2], e[3]}};
    case 3:
    case 12:
      return {{e[3], e[1]}};
    case 6:
    case 9:
      return {{e[0], e[2]}};
    case 5:
      if (middle) return {{e[0], e[1]}, {e[2], e[3]}};
      return {{e[3], e[0]}, {e[1], e[2]}};
    case 10:
      if (middle) return {{e[3], e[0]}, {e[1], e[2]}};
      return {{e[0], e[1]}, {e[2], e[3]}};
    default:
      return {};
  }
}

}  // namespace

std::vector<Path> contour_lines(const HeightField& field, double level) {
  const Cells cells(field);
  std::vector<Segment> all;
  std::map<Edge, std::array<std::ptrdiff_t, 2>> at;  // of each edge the two segments that end there
  for (std::size_t row = 0; row < cells.rows(); ++row)
    for (std::size_t column = 0; column < cells.columns(); ++column)
      for (const Segment& s : segments(cells, row, column, level)) {
        const auto index = static_cast<std::ptrdiff_t>(all.size());
        all.push_back(s);
        for (const Edge& e : {s.from, s.to}) {
          auto [place, fresh] = at.try_emplace(e, std::array<std::ptrdiff_t, 2>{-1, -1});
          place->second[fresh ? 0 : 1] = index;
        }
      }
  std::vector<bool> used(all.size());
  const auto follow = [&](std::size_t start, Edge edge) {
    Path path;
    auto index = static_cast<std::ptrdiff_t>(start);
    const auto add = [&](Edge e) {
      const Corner c = cells.on(e, level);
      path.x.push_back(c.x);
      path.y.push_back(c.y);
    };
    add(edge);
    while (index >= 0 && !used[static_cast<std::size_t>(index)]) {
      used[static_cast<std::size_t>(index)] = true;
      const Segment& s = all[static_cast<std::size_t>(index)];
      edge = s.from == edge ? s.to : s.from;
      add(edge);
      const auto& pair = at[edge];
      index = pair[0] == index ? pair[1] : pair[0];
    }
    return path;
  };
  std::vector<Path> paths;
  // Open lines first, from their ends; what is left are rings.
  for (std::size_t i = 0; i < all.size(); ++i)
    for (const Edge& e : {all[i].from, all[i].to})
      if (!used[i] && at[e][1] < 0) paths.push_back(follow(i, e));
  for (std::size_t i = 0; i < all.size(); ++i)
    if (!used[i]) paths.push_back(follow(i, all[i].from));
  return paths;
}

std::vector<Path> area_above(const HeightField& field, double level) {
  const Cells cells(field);
  std::vector<Path> result;
  const auto add = [&](std::initializer_list<Corner> corners) {
    Path path;
    for (const Corner& c : corners) {
      path.x.push_back(c.x);
      path.y.push_back(c.y);
    }
    result.push_back(std::move(path));
  };
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    // Neighbouring cells that are above as a whole become one box.
    std::size_t begin = cells.columns();
    const auto flush = [&](std::size_t end) {
      if (begin < end)
        add({cells.corner(row, begin), cells.corner(row, end), cells.corner(row + 1, end),
             cells.corner(row + 1, begin)});
      begin = cells.columns();
    };
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      const std::array<Corner, 4> c = cells.cell(row, column);
      const bool seen = finite(c);
      const auto high = [&](std::size_t i) { return c[i].z >= level; };
      if (seen && high(0) && high(1) && high(2) && high(3)) {
        begin = std::min(begin, column);
        continue;
      }
      flush(column);
      if (!seen) continue;
      // Round the cell: corners above, and the points where the edges pass the level.
      const std::array<Edge, 4> e = cells.edges(row, column);
      std::vector<Corner> ring;
      for (std::size_t i = 0; i < 4; ++i) {
        if (high(i)) ring.push_back(c[i]);
        if (high(i) != high((i + 1) % 4)) ring.push_back(cells.on(e[i], level));
      }
      const bool saddle = ring.size() == 6;
      const bool middle = (c[0].z + c[1].z + c[2].z + c[3].z) / 4 >= level;
      if (saddle && !middle) {
        // Two corners apart. The ring starts with a corner or with a passing point.
        const std::size_t shift = high(0) ? 5 : 1;
        const auto at = [&](std::size_t i) { return ring[(i + shift) % 6]; };
        add({at(0), at(1), at(2)});
        add({at(3), at(4), at(5)});
      } else if (ring.size() >= 3) {
        Path path;
        for (const Corner& corner : ring) {
          path.x.push_back(corner.x);
          path.y.push_back(corner.y);
        }
        result.push_back(std::move(path));
      }
    }
    flush(cells.columns());
  }
  return result;
}

std::vector<double> nice_levels(const std::vector<double>& z, int count) {
  double lower = 1, upper = -1;
  for (const double v : z) {
    if (!std::isfinite(v)) continue;
    if (lower > upper) lower = upper = v;
    lower = std::min(lower, v);
    upper = std::max(upper, v);
  }
  if (!(lower < upper)) return {};
  Ruler ruler;
  ruler.lower = lower;
  ruler.upper = upper;
  set_ticks(ruler, std::clamp(count, 2, 11), false);
  std::vector<double> levels;
  for (const Tick& tick : ruler.ticks)
    if (tick.value > lower && tick.value < upper) levels.push_back(tick.value);
  return levels;
}

}  // namespace plantloop
