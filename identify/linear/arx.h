// ARX and FIR by least squares: rows of past outputs and inputs.

#pragma once

#include "identify/linear/fit_linear.h"
#include "identify/linear/least_squares.h"

namespace plantloop::identify {

// Psi theta = y with rows [-y(k-1) ... -y(k-na), u1(k-d-1) ... u1(k-d-nb), u2 ..., 1], the 1 only with an `offset`;
// rows with missing values left out, from sample `first` of each experiment on (the longest lag if that is more).
struct ArxRows {
  Eigen::MatrixXd Psi;
  Eigen::VectorXd y;
  Eigen::Index left_out = 0;
};
ArxRows arx_rows(const DataSet& data, const Orders& orders, std::size_t output, bool offset = false,
                 Eigen::Index first = 0);

PolynomialModel fit_arx(const LinearTask& task, const LinearOptions& options);

// The name of what orders make: FIR, ARX, ...
std::string structure_name(const Orders& orders);
// What was asked for where it is not the default.
std::vector<std::string> options_of(const LinearOptions& options);
// Warns where prediction errors have a mean that chance does not explain; the means of 20 blocks tell how far apart
// means lie that have the same cause, also with coloured errors.
void warn_of_constant(PolynomialModel& model, const Eigen::VectorXd& errors);
// The model of a task with its operating point; all parameters 0.
PolynomialModel begin_model(const LinearTask& task);

}  // namespace plantloop::identify
