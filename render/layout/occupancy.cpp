// The coarse map of a panel.

#include "render/layout/occupancy.h"

#include <algorithm>
#include <cmath>

namespace plantloop {

Occupancy::Occupancy(const Box& box, double cell)
    : box_(box),
      cell_(cell),
      columns_(std::max(1, static_cast<int>(std::ceil(box.width() / cell)))),
      rows_(std::max(1, static_cast<int>(std::ceil(box.height() / cell)))),
      cells_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}

void Occupancy::mark(int column, int row, int weight) {
  if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return;
  auto& cell =
      cells_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column)];
  cell = static_cast<std::uint8_t>(std::max<int>(cell, weight));
}

void Occupancy::add_line(const Curve& curve) {
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Spot a = curve[i], b = curve[std::min(i + 1, curve.size() - 1)];
    const double length = std::max(std::abs(b.x - a.x), std::abs(b.y - a.y));
    const int steps = 1 + static_cast<int>(std::min(length / cell_, 1e5));
    for (int k = 0; k <= steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      mark(static_cast<int>(std::floor((a.x + t * (b.x - a.x) - box_.left) / cell_)),
           static_cast<int>(std::floor((a.y + t * (b.y - a.y) - box_.top) / cell_)), line_weight);
    }
  }
}

void Occupancy::add_area(const Curve& ring) {
  std::vector<double> crossings;
  double left = box_.right, right = box_.left;
  for (const Spot s : ring) left = std::min(left, s.x), right = std::max(right, s.x);
  const auto column_of = [&](double x) { return static_cast<int>(std::floor((x - box_.left) / cell_)); };
  const int begin = left > box_.left ? column_of(left) : 0, end = right < box_.right ? column_of(right) + 1 : columns_;
  for (int column = begin; column < std::min(end, columns_); ++column) {
    const double x = box_.left + (column + 0.5) * cell_;
    crossings.clear();
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Spot a = ring[i], b = ring[(i + 1) % ring.size()];
      if ((a.x <= x) != (b.x <= x)) crossings.push_back(a.y + (b.y - a.y) * ((x - a.x) / (b.x - a.x)));
    }
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
      const int first = static_cast<int>(std::floor((crossings[i] - box_.top) / cell_));
      const int last = static_cast<int>(std::floor((crossings[i + 1] - box_.top) / cell_));
      for (int row = std::max(first, 0); row <= std::min(last, rows_ - 1); ++row) mark(column, row, 1);
    }
  }
}

void Occupancy::add_box(const Box& box, int weight) {
  const auto cell = [&](double v) { return static_cast<int>(std::floor(v / cell_)); };
  for (int row = cell(box.top - box_.top); row <= cell(box.bottom - box_.top); ++row)
    for (int column = cell(box.left - box_.left); column <= cell(box.right - box_.left); ++column)
      mark(column, row, weight);
}

double Occupancy::covered(const Box& box) const {
  double sum = 0;
  const auto cell = [&](double v) { return static_cast<int>(std::floor(v / cell_)); };
  for (int row = cell(box.top - box_.top); row <= cell(box.bottom - box_.top); ++row)
    for (int column = cell(box.left - box_.left); column <= cell(box.right - box_.left); ++column) {
      const bool outside = column < 0 || row < 0 || column >= columns_ || row >= rows_;
      sum += outside ? 100
                     : cells_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                              static_cast<std::size_t>(column)];
    }
  return sum;
}

}  // namespace plantloop
