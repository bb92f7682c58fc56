// Measures of a signal, all computed on one polyline: the points of the window, two where the signal jumps.

#include "engine/run/measures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace plantloop {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

struct Point {
  double t, y;
};
using Line = std::vector<Point>;

Line line_of(const Recording& recording, std::size_t column, double from, double until) {
  Line line;
  if (recording.rows() == 0) return line;
  const std::vector<double>& time = recording.time();
  from = std::max(from, time.front());
  until = std::min(until, time.back());
  if (from > until) return line;
  const auto first = static_cast<std::size_t>(std::upper_bound(time.begin(), time.end(), from) - time.begin());
  const bool to_the_end = until == time.back();
  const bool held = recording.columns[column].rate != 0;
  const auto add = [&](double t, double y) {
    if (held && !line.empty() && y != line.back().y && t > line.back().t) line.push_back({t, line.back().y});
    line.push_back({t, y});
  };
  add(from, recording.value(column, from));
  for (std::size_t row = first; row < time.size() && (time[row] < until || to_the_end); ++row) {
    add(time[row], recording.at(row, column));
  }
  if (!to_the_end && until > from) {
    // The left side of a discrete column is what it held.
    line.push_back({until, held ? line.back().y : recording.value(column, until, true)});
  }
  return line;
}

double highest(const Line& line) {
  return std::max_element(line.begin(), line.end(), [](Point a, Point b) { return a.y < b.y; })->y;
}

double lowest(const Line& line) {
  return std::min_element(line.begin(), line.end(), [](Point a, Point b) { return a.y < b.y; })->y;
}

// The integral of y^2 along straight lines is exact: (a^2 + a b + b^2) / 3 per piece.
double root_mean_square(const Line& line) {
  const double duration = line.back().t - line.front().t;
  if (duration <= 0) return std::abs(line.back().y);
  double sum = 0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double a = line[i - 1].y;
    const double b = line[i].y;
    sum += (line[i].t - line[i - 1].t) * (a * a + a * b + b * b) / 3;
  }
  return std::sqrt(sum / duration);
}

// Where the piece from a to b meets the level that lies between its ends.
double meeting(Point a, Point b, double level) {
  return b.y == a.y ? b.t : a.t + (b.t - a.t) * ((level - a.y) / (b.y - a.y));
}

// The first time at which y reaches the level from below; infinite when it does not.
double first_reach(const Line& line, double level) {
  if (line.front().y >= level) return line.front().t;
  for (std::size_t i = 1; i < line.size(); ++i) {
    if (line[i].y >= level) return meeting(line[i - 1], line[i], level);
  }
  return infinity;
}

// The last time at which |y - 1| passes the band; the start when it never is outside, infinite when it ends outside.
double last_outside(const Line& line, double band) {
  if (std::abs(line.back().y - 1) > band) return infinity;
  for (std::size_t i = line.size() - 1; i > 0; --i) {
    if (std::abs(line[i - 1].y - 1) > band) {
      return meeting(line[i - 1], line[i], line[i - 1].y > 1 ? 1 + band : 1 - band);
    }
  }
  return line.front().t;
}

// The signal in terms of its step: 0 before, 1 after. Empty when the step has no height.
Line normalised(const Recording& recording, std::size_t column, const MeasureOptions& options) {
  const double at = options.step.at.value_or(options.from);
  Line line = line_of(recording, column, at, options.step.until.value_or(options.until));
  if (line.empty()) return line;
  const double from = options.step.from.value_or(recording.value(column, line.front().t, true));
  const double to = options.step.to.value_or(line.back().y);
  if (to == from) return {};
  for (Point& point : line) point.y = (point.y - from) / (to - from);
  return line;
}

double step_measure(const Line& line, std::string_view name, double band) {
  if (line.empty()) return nothing;
  if (name == "overshoot") return 100 * std::max(0.0, highest(line) - 1);
  if (name == "undershoot") return 100 * std::max(0.0, -lowest(line));
  if (name == "settling_time") return last_outside(line, band) - line.front().t;
  const double begin = first_reach(line, 0.1);
  const double end = first_reach(line, 0.9);
  return std::isinf(end) ? infinity : end - begin;
}

}  // namespace

const std::vector<MeasureInfo>& measures() {
  static const std::vector<MeasureInfo> list{
      {"max", "the largest value", ""},
      {"min", "the smallest value", ""},
      {"max_abs", "the largest magnitude", ""},
      {"rms", "the root of the mean square over time", ""},
      {"final", "the last value", ""},
      {"overshoot", "how far it goes beyond the end of its step, in percent of the step", "%", true},
      {"undershoot", "how far it first goes the wrong way, in percent of the step", "%", true},
      {"settling_time", "from the step until it stays within the band", "s", true},
      {"rise_time", "from 10 to 90 percent of the step", "s", true},
  };
  return list;
}

double measure(const Recording& recording, std::size_t column, std::string_view name, const MeasureOptions& options) {
  const auto info = std::find_if(measures().begin(), measures().end(), [&](const auto& m) { return m.name == name; });
  if (info == measures().end()) throw std::invalid_argument(fmt::format("there is no measure '{}'", name));
  if (info->of_step) return step_measure(normalised(recording, column, options), name, options.band);
  const Line line = line_of(recording, column, options.from, options.until);
  if (line.empty()) return nothing;
  if (name == "max") return highest(line);
  if (name == "min") return lowest(line);
  if (name == "max_abs") return std::max(std::abs(highest(line)), std::abs(lowest(line)));
  if (name == "rms") return root_mean_square(line);
  return line.back().y;
}

}  // namespace plantloop
