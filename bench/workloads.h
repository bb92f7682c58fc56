// The benchmarks as numbers, shared by the hand-written programs and the writers of the diagrams.

#pragma once

#include <array>
#include <string>
#include <vector>

#include "bench/measured.h"

namespace plantloop::bench {

// The damped pendulum theta'' = b F - Q theta' - Q sin(theta) under a staircase force, from rest.
struct Pendulum {
  double Q = 29.46;  // 1/s, 1/s^2
  double b = 1.21;
  std::array<double, 6> times{0, 1, 7, 13, 19, 25};  // s
  std::array<double, 6> forces{0, 8, 16, 22, 12, 4};
  double step = 1e-3;  // s
  long steps = 1'000'000;
};

// First-order lags x_i' = gain_i (x_(i-1) - x_i), the first of which follows a constant 1; all start at 0.
struct Chain {
  std::vector<double> gains;  // 1/s, all different
  double step = 1e-3;         // s
  long steps = 0;
};

// A chain whose delay is about the whole time, so that the last lag ends on its way from 0 to 1.
Chain make_chain(int lags, long steps);

// Hand-written classical Runge-Kutta: records theta and omega, and the last lag, after each step.
Measured run_handwritten(const Pendulum& pendulum);
Measured run_handwritten(const Chain& chain);

enum class Order { declared, random };

// The same as diagrams of elementary blocks: staircase, gain, sum, math, integrator.
std::string to_yaml(const Pendulum& pendulum);
std::string to_yaml(const Chain& chain, Order order);

}  // namespace plantloop::bench
