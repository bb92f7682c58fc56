// Values are compared at the samples that are wanted, never at times that somebody invented.

#include "engine/run/compare.h"

#include <algorithm>
#include <cmath>

namespace plantloop {

namespace {

enum class Side { left, right, only };

// The values that a signal has at one time: one, or the two that a file between two samples may mean.
struct Values {
  double a = NAN, b = NAN;
  bool exists = false;
};

Values value_at(const SampledSignal& s, double t, Side side) {
  if (s.time.empty() || t < s.time.front() || t > s.time.back()) return {};
  const auto first = s.time.begin();
  const auto from = std::lower_bound(first, s.time.end(), t);
  const auto to = std::upper_bound(from, s.time.end(), t);
  if (from != to) {
    const auto index = [&](auto it) { return static_cast<std::size_t>(it - first); };
    const double left = s.value[index(from)];
    const double right = s.value[index(to) - 1];
    // Where only one of the two has a jump, its other side has no counterpart: the nearer one counts.
    return {side == Side::right ? right : left, side == Side::left ? left : right, true};
  }
  const auto k = static_cast<std::size_t>(from - first) - 1;
  const double share = (t - s.time[k]) / (s.time[k + 1] - s.time[k]);
  const double line = s.value[k] + share * (s.value[k + 1] - s.value[k]);
  if (s.between == SampledSignal::Between::line) return {line, line, true};
  if (s.between == SampledSignal::Between::held) return {s.value[k], s.value[k], true};
  return {line, s.value[k], true};
}

// 0 when both are the same, also the same that is no number.
double distance(double a, double b) {
  if (a == b || (std::isnan(a) && std::isnan(b))) return 0;
  const double d = std::fabs(a - b);
  return std::isnan(d) ? INFINITY : d;
}

// The value of the signal nearest to `wanted` at t or, with a shift, anywhere in the window around it.
Values nearest_value(const SampledSignal& s, double t, Side side, double shift, double wanted) {
  const Values here = value_at(s, t, side);
  if (!here.exists && shift <= 0) return here;
  double best = here.a;
  const auto take = [&](double v) {
    if (distance(v, wanted) < distance(best, wanted) || std::isnan(best)) best = v;
  };
  if (here.exists) take(here.b);
  if (shift <= 0) return {best, best, true};
  double low = here.exists ? best : INFINITY;
  double high = here.exists ? best : -INFINITY;
  const auto widen = [&](double v) { low = std::min(low, v), high = std::max(high, v); };
  for (const double edge : {t - shift, t + shift}) {
    const double inside = std::clamp(edge, s.time.front(), s.time.back());
    if (std::fabs(inside - t) > shift) continue;
    for (const Side each : {Side::left, Side::right}) {
      const Values v = value_at(s, inside, each);
      widen(v.a), widen(v.b);
    }
  }
  auto it = std::lower_bound(s.time.begin(), s.time.end(), t - shift);
  for (; it != s.time.end() && *it <= t + shift; ++it) widen(s.value[static_cast<std::size_t>(it - s.time.begin())]);
  if (low > high) return {};
  const double nearest = std::clamp(wanted, low, high);
  return {nearest, nearest, true};
}

}  // namespace

std::vector<Deviation> deviations(const SampledSignal& signal, const SampledSignal& wanted,
                                  const Tolerance& tolerance) {
  std::vector<Deviation> all;
  all.reserve(wanted.time.size());
  for (std::size_t i = 0; i < wanted.time.size(); ++i) {
    const double t = wanted.time[i];
    const bool left = i + 1 < wanted.time.size() && wanted.time[i + 1] == t;
    const bool right = i > 0 && wanted.time[i - 1] == t;
    const Side side = left ? Side::left : right ? Side::right : Side::only;
    const Values found = nearest_value(signal, t, side, tolerance.shift, wanted.value[i]);
    Deviation one;
    one.time = t;
    one.wanted = wanted.value[i];
    one.found = found.a;
    one.outside = !found.exists;
    one.distance = found.exists ? distance(found.a, one.wanted) : INFINITY;
    const double size = std::fabs(tolerance.of_signal ? one.found : one.wanted);
    one.allowed = tolerance.abs + (tolerance.rel > 0 && std::isfinite(size) ? tolerance.rel * size : 0);
    one.met = one.distance == 0 || one.distance <= one.allowed;
    all.push_back(one);
  }
  return all;
}

Deviation worst_deviation(const SampledSignal& signal, const SampledSignal& wanted, const Tolerance& tolerance) {
  const auto better = [](const Deviation& a, const Deviation& b) {
    if (a.met != b.met) return a.met;
    return a.distance - a.allowed < b.distance - b.allowed;
  };
  const std::vector<Deviation> all = deviations(signal, wanted, tolerance);
  return all.empty() ? Deviation{} : *std::max_element(all.begin(), all.end(), better);
}

SampledSignal signal_of(const Recording& recording, std::size_t column) {
  return {recording.time(), recording.column(column),
          recording.columns[column].rate == 0 ? SampledSignal::Between::line : SampledSignal::Between::held};
}

std::vector<std::string> signal_names(const CsvTable& table) {
  std::vector<std::string> names;
  for (const std::string& name : table.names) {
    if (name != "time") names.push_back(name);
  }
  return names;
}

SampledSignal signal_of(const CsvTable& table, std::size_t column, std::size_t time_column) {
  return {table.columns[time_column], table.columns[column], SampledSignal::Between::either};
}

}  // namespace plantloop
