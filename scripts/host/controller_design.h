// Controllers for linear models.

#pragma once

#include <Eigen/Core>
#include <span>

#include "engine/analysis/linear_model.h"
#include "identify/velocity/controller_family.h"
#include "scripts/host/stack.h"

namespace plantloop::lua {

// K exp(-theta s)/(T s + 1).
struct Lag {
  double gain = 0, time_constant = 0, dead_time = 0;
};
// The lag that answers a step of height `size` at `at` as y did, by the times at which y has done 28.3 % and 63.2 % of
// its way (C. L. Smith 1972).
Lag lag_of(std::span<const double> time, std::span<const double> y, double size, double at);

// kp, ki, kd with which the loop around the lag answers a set point with the time constant lambda (E. B. Dahlin 1968;
// with derivative D. E. Rivera, M. Morari and S. Skogestad 1986).
identify::ControllerPoint lambda_tuned(const Lag& lag, double lambda, bool derivative);

// The row K that gives A - B K this characteristic polynomial, descending powers (J. Ackermann 1972), for one input.
Eigen::VectorXd placed(const Eigen::MatrixXd& A, const Eigen::VectorXd& B, const Eigen::VectorXd& polynomial);
// The polynomial with the roots of the array on the stack: numbers, or rows of real and imaginary parts.
Eigen::VectorXd polynomial_of_poles(lua_State* L, int index);

// A controller of the model's one output by its one input, by the options {method = ..., controller = ...}.
identify::ControllerPoint designed(lua_State* L, const Options& options, const LinearModel& model);
// The names of those options.
std::vector<std::string> design_options();

// The table at the index, as diagram:linearise gives it, or an identified linear model.
LinearModel linear_model_argument(lua_State* L, int index);

}  // namespace plantloop::lua
