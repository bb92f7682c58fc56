// What a user would program by hand: DOPRI5 as its author shows it, without any of ours.

#pragma once

#include <functional>
#include <vector>

namespace plantloop::accuracy {

struct Tolerances {
  double rtol = 1e-6, atol = 1e-9;
};
// x' = f(t, x).
using Rates = std::function<void(double t, const double* x, double* rate)>;

// x(stop) from x(0) by the method of Dormand and Prince as in Hairer's DOPRI5.
std::vector<double> by_dopri5(const Rates& f, std::vector<double> x, double stop, const Tolerances& tolerances);

}  // namespace plantloop::accuracy
