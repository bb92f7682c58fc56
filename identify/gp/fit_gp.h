// Hyperparameters of a Gaussian process from data: maximum likelihood.

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "identify/fit/minimise.h"
#include "identify/fit_report.h"
#include "identify/gp/gaussian_process.h"

namespace plantloop::identify {

struct GpOptions {
  std::string covariance = "se_ard";
  std::string mean = "zero";  // "zero", "constant", "linear"
  int starts = 10;            // the first one is a guess from the data, the others are random around it
  int max_iterations = 200;
  Descent method = Descent::quasi_newton;
  double bound = 12;  // the logarithms stay within this distance of the guess
  std::uint64_t seed = 1;
  int threads = 0;  // 0: as many as the machine has; the result does not depend on it
  // Where the first start begins instead of the guess. With max_iterations = 0 the process is made of them as they are.
  std::optional<Hyperparameters> start;
};

// One of the optima that were found.
struct GpOptimum {
  Hyperparameters hyperparameters;
  double log_likelihood = 0;
};

struct GpFit {
  GaussianProcess model;
  FitReport report;               // criterion: log likelihood, greater is better
  std::vector<GpOptimum> optima;  // the different ones, best first
};

// x: N x D (of a covariance with_slopes: N x (D + 2)), y: N. Maximises the log marginal likelihood over the logarithms
// of theta and v0. Throws IdentifyError.
GpFit fit_gp(const Eigen::MatrixXd& x, const Eigen::VectorXd& y, const GpOptions& options = {},
             const FitControl& control = {});
// With this covariance instead of the options'.
GpFit fit_gp(std::shared_ptr<const Covariance> covariance, const Eigen::MatrixXd& x, const Eigen::VectorXd& y,
             const GpOptions& options = {}, const FitControl& control = {});

// Means and variances (with noise) of contiguous folds, each predicted from the others: fold i holds rows with
// floor(i k/n). `refit`: with hyperparameters of its own, started at those of `model`; else with those of `model`.
LeaveOneOut cross_validate(const GaussianProcess& model, int folds, bool refit = false);

}  // namespace plantloop::identify
