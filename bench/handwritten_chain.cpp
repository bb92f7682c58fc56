// The chain of lags as somebody writes it who needs it once and fast: arrays, and loops that the compiler vectorises.

#include <cstddef>
#include <vector>

#include "bench/workloads.h"

namespace plantloop::bench {
namespace {

using Numbers = std::vector<double>;

void derivative(const Numbers& gains, const Numbers& x, Numbers& rate) {
  const std::size_t n = x.size();
  const double* __restrict k = gains.data();
  const double* __restrict state = x.data();
  double* __restrict out = rate.data();
  out[0] = k[0] * (1.0 - state[0]);
  for (std::size_t i = 1; i < n; ++i) out[i] = k[i] * (state[i - 1] - state[i]);
}

void move(const Numbers& x, double h, const Numbers& rate, Numbers& to) {
  const std::size_t n = x.size();
  const double* __restrict from = x.data();
  const double* __restrict slope = rate.data();
  double* __restrict out = to.data();
  for (std::size_t i = 0; i < n; ++i) out[i] = from[i] + h * slope[i];
}

void combine(Numbers& x, double h, const Numbers& r1, const Numbers& r2, const Numbers& r3, const Numbers& r4) {
  const std::size_t n = x.size();
  const double* __restrict k1 = r1.data();
  const double* __restrict k2 = r2.data();
  const double* __restrict k3 = r3.data();
  const double* __restrict k4 = r4.data();
  double* __restrict out = x.data();
  for (std::size_t i = 0; i < n; ++i) out[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
}

}  // namespace

Chain make_chain(int lags, long steps) {
  Chain chain{.gains = {}, .steps = steps};
  const double middle = lags / (chain.step * static_cast<double>(steps));
  for (int i = 0; i < lags; ++i) chain.gains.push_back(middle * (0.75 + 0.5 * (i + 1) / lags));
  return chain;
}

Measured run_handwritten(const Chain& chain) {
  const std::size_t n = chain.gains.size();
  const double h = chain.step;
  Numbers x(n), at(n), r1(n), r2(n), r3(n), r4(n);
  Numbers last{x.back()};

  const Stopwatch watch;
  for (long i = 0; i < chain.steps; ++i) {
    derivative(chain.gains, x, r1);
    move(x, h / 2, r1, at);
    derivative(chain.gains, at, r2);
    move(x, h / 2, r2, at);
    derivative(chain.gains, at, r3);
    move(x, h, r3, at);
    derivative(chain.gains, at, r4);
    combine(x, h, r1, r2, r3, r4);
    last.push_back(x.back());
  }
  return {.seconds = watch.seconds(), .value = last.back()};
}

}  // namespace plantloop::bench
