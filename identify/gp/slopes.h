// Observations of slopes: what is known of a function's partial derivatives, as linear local models know it.

#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "identify/gp/covariance.h"
#include "identify/linear/polynomial_model.h"
#include "identify/regressors/regressors.h"

namespace plantloop::identify {

// A covariance between values and partial derivatives of one function (E. Solak, R. Murray-Smith, W. Leithead,
// D. Leith, C. Rasmussen 2003): cov(df/dx_d, f(z)) = dk/dx_d, cov(df/dx_d, df/dz_e) = d2k/dx_d dz_e.
//
// Points have two more columns than inputs: what is observed there, 0 for the value, d for the slope by input d (from
// 1); and the variance of its noise, -1 where that is the hyperparameter v0. Points without these columns are values.
// Own noise stands on the diagonal of lower(). name() and hyperparameters are those of the base.
// Raises IdentifyError when the functions of the base have no slopes.
std::shared_ptr<const Covariance> with_slopes(std::shared_ptr<const Covariance> base, int inputs);

// What is known of an output beside its measurements, in the user's units.
struct Observation {
  Eigen::VectorXd x;  // D
  int slope_of = 0;   // 0: the value; d: the partial derivative by input d, from 1
  double value = 0;
  double noise = 0;  // variance, 0 or greater
};

// What a linear model about its operating point says of y(k) = f(regressors): the value at rest, with the variance of a
// mean of its samples, and the slopes by all lags that it has, with the variances of its parameters (of a common
// denominator to first order). The regressors must be single lags, the constant apart. Raises IdentifyError: a lag of
// the model is not among them, signals with other names, no rest as Ts differs.
std::vector<Observation> observations_of(const PolynomialModel& model, const RegressorSet& regressors);

// The rows of observations for a covariance with_slopes: x, what, noise.
Eigen::MatrixXd rows_of(const std::vector<Observation>& observations, int inputs);

}  // namespace plantloop::identify
