// Hyperparameters and inducing inputs of a sparse process from data.

#pragma once

#include <Eigen/Core>

#include "identify/gp/fit_gp.h"
#include "identify/gp/sparse.h"

namespace plantloop::identify {

struct SparseOptions {
  SparseMethod method = SparseMethod::fitc;
  int inducing = 50;       // how many; begun at the centres of clusters of the inputs
  Eigen::MatrixXd inputs;  // these instead, M x D, when not empty
  bool hold = false;       // the inducing inputs stay where they begin
  int refined = 2;         // of the optima of the first stage, so many are trained on
};

struct SparseFit {
  SparseGaussianProcess model;
  FitReport report;  // criterion: the log likelihood or its bound, greater is better
};

// Maximises sparse_likelihood() over the logarithms of theta and v0 and over the inducing inputs. First an exact
// process is fitted to at most 500 rows, drawn from all, from options.starts starts; its best optima are where the
// sparse ones begin. With options.start the one descent begins there, and with no iterations nothing is trained.
// Time of an iteration grows with N M^2, memory with N M. Throws IdentifyError.
SparseFit fit_sparse(const Eigen::MatrixXd& x, const Eigen::VectorXd& y, const GpOptions& options,
                     const SparseOptions& sparse, const FitControl& control = {});

}  // namespace plantloop::identify
