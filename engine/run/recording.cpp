// The table of a run: appending, looking up, interpolating.

#include "engine/run/recording.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace plantloop {
std::vector<double> Recording::column(std::size_t index) const {
  std::vector<double> values(rows());
  for (std::size_t row = 0; row < rows(); ++row) values[row] = at(row, index);
  return values;
}

int Recording::find(std::string_view name) const {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

void Recording::reserve(std::size_t rows) {
  time_.reserve(rows);
  side_.reserve(rows);
  values_.reserve(rows * columns.size());
}

void Recording::remove_last_row() {
  assert(!time_.empty());
  time_.pop_back();
  side_.pop_back();
  values_.resize(values_.size() - columns.size());
  for (std::vector<std::size_t>& rows : hits) {
    while (!rows.empty() && rows.back() >= time_.size()) rows.pop_back();
  }
}

double Recording::sampled(std::size_t column, double time, bool left) const {
  for (const Sample& sample : samples) {
    if (sample.time != time) continue;
    const std::vector<double>& row = left ? sample.left : sample.right;
    if (!row.empty()) return row[column];
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double Recording::value(std::size_t column, double t, bool left) const {
  assert(!time_.empty());
  const auto first = time_.begin();
  // The last row that counts as not after t, and the first that counts as not before.
  const auto after = left ? std::lower_bound(first, time_.end(), t) : std::upper_bound(first, time_.end(), t);
  if (left && after != time_.end() && *after == t) return at(static_cast<std::size_t>(after - first), column);
  if (after == first) return at(0, column);
  const auto row = static_cast<std::size_t>(after - first) - 1;
  const double value = at(row, column);
  if (after == time_.end() || columns[column].rate != 0 || time_[row] == t) return value;
  const double share = (t - time_[row]) / (time_[row + 1] - time_[row]);
  return value + share * (at(row + 1, column) - value);
}

}  // namespace plantloop
