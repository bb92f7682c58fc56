// Units in which the signals of a linear fit are of size 1, so that its result does not depend on the user's units.

#pragma once

#include "identify/linear/fit_linear.h"

namespace plantloop::identify {

// Powers of two near the root mean squares of the signals (1 for signals of zeros), so that dividing by them is exact.
struct SignalUnits {
  Eigen::VectorXd u;  // of each input
  double y = 1;       // of the task's output
};
SignalUnits units_of(const LinearTask& task);

// The root mean square of the values that are there; 1 when all are 0.
double size_of(const Eigen::VectorXd& values);

// The task with its signals in these units. Its operating point stays as it is.
LinearTask in_units(LinearTask task, const SignalUnits& units);

// The factors that turn parameters() of a model of such a task into those of the task before.
Eigen::VectorXd parameter_units(const PolynomialModel& model, const SignalUnits& units);

// Turns a model of such a task into one of the task before: parameters, covariance, variance, and what was reached.
void restore(PolynomialModel& model, const SignalUnits& units);

}  // namespace plantloop::identify
