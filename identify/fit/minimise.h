// The minimum of a smooth function between bounds.

#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>

namespace plantloop::identify {

// The value at x, and the gradient when `gradient` is not null. A value that is not finite says that the function is
// not defined at x; such a step is taken back.
using Objective = std::function<double(const Eigen::VectorXd& x, Eigen::VectorXd* gradient)>;

enum class Descent { quasi_newton, conjugate_gradient };

struct MinimiseOptions {
  Descent method = Descent::quasi_newton;
  int max_iterations = 200;
  double gradient_tolerance = 1e-7;   // of the greatest element, relative to max(1, |value|)
  double decrease_tolerance = 1e-13;  // of three steps in a row, relative to max(1, |value|)
  Eigen::VectorXd lower, upper;       // empty: none
};

struct Minimum {
  Eigen::VectorXd x;
  double value = 0;
  Eigen::VectorXd gradient;
  int iterations = 0;
  int evaluations = 0;
  std::string stop;
};

// Quasi-Newton (Broyden, Fletcher, Goldfarb, Shanno) or conjugate gradients (Polak and Ribiere, never negative), both
// on the free variables of a box, with a line search for the weak Wolfe conditions by bisection (A. Lewis, M. Overton,
// Mathematical Programming 141 (2013)).
Minimum minimise(const Objective& objective, const Eigen::VectorXd& start, const MinimiseOptions& options = {});

}  // namespace plantloop::identify
