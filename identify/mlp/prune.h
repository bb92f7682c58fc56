// Optimal brain surgeon: weights taken out one by one, always the one that is missed least.

#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "identify/fit_report.h"
#include "identify/mlp/network.h"

namespace plantloop::identify {

struct PruneOptions {
  double decay = 0;     // D of every weight, as in training
  int iterations = 50;  // of Levenberg-Marquardt after each removal
  int least = 1;        // weights at which pruning ends
};

struct PruneStep {
  int weights = 0;      // that are not 0
  double sse = 0;       // of the normalised training data
  double test_sse = 0;  // of the test data; 0 without
  double fpe = 0;       // final prediction error
  Eigen::VectorXd theta;
};

struct Pruned {
  std::shared_ptr<const Mlp> model;  // the least test error, or without test data the least FPE
  std::vector<PruneStep> steps;      // from the whole network to the smallest one
  std::size_t best = 0;              // which of them is the model
  FitReport report;
};

// B. Hassibi and D. Stork 1993, with weight decay after M. Norgaard et al. 2000. With H = J'J + D the removal of weight
// j changes the others by -(theta_j/[H^-1]_jj) H^-1 e_j and raises the training error by
//   zeta_j = c_j [H^-1 D theta]_j + c_j^2 [H^-1 R H^-1]_jj/2,   c_j = theta_j/[H^-1]_jj.
// A neuron that would lose its last outgoing or its last incoming weight is removed as a whole, ranked by its joint
// saliency 1/2 theta_E' ([H^-1]_EE)^-1 theta_E. X, Y, X_test, Y_test in the user's units; the test data may be empty.
// Raises IdentifyError.
Pruned prune(const Mlp& model, const Eigen::MatrixXd& X, const Eigen::MatrixXd& Y, const Eigen::MatrixXd& X_test,
             const Eigen::MatrixXd& Y_test, const PruneOptions& options = {}, const FitControl& control = {});

}  // namespace plantloop::identify
