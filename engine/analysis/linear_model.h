// A linear model, x' = A x + B u, y = C x + D u (or x[k+1] = ... with a period), and what can be asked of it.

#pragma once

#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "engine/analysis/matrix.h"

namespace plantloop {

struct LinearModel {
  std::vector<std::string> states, inputs, outputs;  // paths; held values are called "held x"
  DenseMatrix A, B, C, D;
  double period = 0;                            // s; 0: continuous
  double time = 0;                              // s; of the operating point
  std::vector<double> x, y;                     // at the operating point
  std::vector<std::string> without_derivative;  // blocks whose part is missing, since their derivative is not known
};

// A continuous model sampled with a period, its inputs held in between and `dead_time` (s) late: exact at the samples
// (K. Astrom and B. Wittenmark, Computer-Controlled Systems, 3.2). Inputs that are on their way are states "u 1 late",
// "u 2 late", ..., with values at the operating point as `u` says, one for each input.
LinearModel sampled(const LinearModel& model, double period, double dead_time, const std::vector<double>& u);

std::vector<std::complex<double>> poles(const LinearModel& model);
// Of the whole transfer matrix; with one input and one output those of the transfer function that are not cancelled,
// and the modes that cannot be reached or seen.
std::vector<std::complex<double>> zeros(const LinearModel& model);
// From input j to output i at i * inputs + j; omega in rad/s. A sampled model answers at exp(i omega period).
std::vector<std::complex<double>> response(const LinearModel& model, double omega);
// C (-A)^-1 B + D, or its sampled counterpart; where A is singular the limit, if there is one.
std::vector<double> gains_at_rest(const LinearModel& model);
// Frequencies, in rad/s, with equal ratios from a tenth of the slowest to ten times the fastest pole or zero.
std::vector<double> frequencies_for(const LinearModel& model, std::size_t count);

// Of a loop that is closed by negative feedback around the open loop from input 0 to output 0. What does not exist, as
// the gain margin of a first-order lag, is not given.
struct Margins {
  std::optional<double> gain, phase_crossover;  // factor, and rad/s where the phase is -180 degrees
  std::optional<double> phase, gain_crossover;  // degrees, and rad/s where the magnitude is 1
  std::optional<double> delay;                  // s; the dead time that uses the phase margin up
};
// The smallest margins over all crossovers; found on a grid of frequencies and refined by bisection.
Margins margins(const LinearModel& model);

}  // namespace plantloop
