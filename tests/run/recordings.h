// Recordings made by hand for the tests of files and measures.

#pragma once

#include <cmath>
#include <cstdint>

#include "engine/run/recording.h"

namespace plantloop::testing {

// One continuous column `y` with rows at 0, step, ..., stop.
template <typename Function>
Recording sampled(double step, double stop, Function y) {
  Recording recording;
  recording.columns = {{.name = "y"}};
  recording.hits.resize(1);
  recording.rates.resize(1);
  for (int k = 0; k * step <= stop * (1 + 1e-12); ++k) {
    const double value = y(k * step);
    recording.append(k * step, 0, {&value, 1});
  }
  return recording;
}

// A ramp `ramp` = t with a jump by 10 at t = 1, a discrete `held` at 0, 0.5, 1 and a hidden column.
inline Recording mixed() {
  Recording recording;
  recording.columns = {
      {.name = "ramp", .unit = "m"}, {.name = "held", .unit = "V", .rate = 1}, {.name = "inner", .hidden = true}};
  recording.hits.resize(2);
  recording.rates = {{0, 0}, {0.5, 0}};
  recording.provenance = {{"diagram", "a \"quoted\"\nname.yaml"}, {"solver", "dopri5"}};
  recording.events = {{"h.reset", {1.0}}};
  const auto add = [&](double t, std::int8_t side, std::vector<double> row, bool hit) {
    recording.append(t, side, row);
    if (hit) recording.mark_hit(1);
  };
  add(0, 0, {0, 1, 7}, true);
  add(0.25, 0, {0.25, 1, 7}, false);
  add(0.5, 0, {0.5, 2, 7}, true);
  add(1, -1, {1, 2, 7}, false);
  add(1, 1, {11, 3, 7}, true);
  add(1.1, 0, {11.1, 3, 8}, false);
  return recording;
}

}  // namespace plantloop::testing
