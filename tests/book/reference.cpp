// Steps of Kutta's method, doubled and extrapolated.

#include "tests/book/reference.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace plantloop::testing_book {
namespace {

State moved(const State& from, long double h, const State& slope) {
  State to = from;
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += h * slope[i];
  return to;
}

State kutta(const RightSide& f, long double t, const State& x, long double h) {
  const State k1 = f(t, x);
  const State k2 = f(t + h / 2, moved(x, h / 2, k1));
  const State k3 = f(t + h / 2, moved(x, h / 2, k2));
  const State k4 = f(t + h, moved(x, h, k3));
  State next = x;
  for (std::size_t i = 0; i < x.size(); ++i) next[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  return next;
}

}  // namespace

State integrate(const RightSide& f, State state, double start, double end, long double tolerance) {
  long double t = start;
  long double h = 1e-5L;
  while (t < end) {
    h = std::min(h, end - t);
    const State whole = kutta(f, t, state, h);
    State halves = kutta(f, t + h / 2, kutta(f, t, state, h / 2), h / 2);
    long double error = 0;
    for (std::size_t i = 0; i < state.size(); ++i) {
      const long double off = (halves[i] - whole[i]) / 15;  // of the halves, to leading order
      error = std::max(error, std::fabs(off) / std::max(1.0L, std::fabs(halves[i])));
      halves[i] += off;
    }
    if (error <= tolerance) {
      const bool last = h >= end - t;
      t = last ? static_cast<long double>(end) : t + h;
      state = halves;
    }
    const long double factor = error > 0 ? 0.9L * std::pow(tolerance / error, 0.2L) : 4.0L;
    h *= std::clamp(factor, 0.2L, 4.0L);
  }
  return state;
}

std::vector<State> integrate_pieces(const PiecewiseRightSide& f, State state, double start,
                                    const std::vector<double>& edges, const std::vector<double>& times) {
  std::vector<State> states;
  double t = start;
  int passed = -1;
  const auto pass_edges = [&] {
    while (passed + 1 < static_cast<int>(edges.size()) && edges[static_cast<std::size_t>(passed + 1)] <= t) ++passed;
  };
  for (const double time : times) {
    for (pass_edges(); t < time; pass_edges()) {
      const auto next = static_cast<std::size_t>(passed + 1);
      const double end = next < edges.size() ? std::min(edges[next], time) : time;
      state = integrate([&](long double, const State& x) { return f(passed, x); }, state, t, end);
      t = end;
    }
    states.push_back(state);
  }
  return states;
}

}  // namespace plantloop::testing_book
