// The learning rules of the first networks: one layer, one sample at a time.

#pragma once

#include <Eigen/Core>

#include "identify/mlp/activation.h"

namespace plantloop::identify {

// Rows of X (N x D) and D (N x units, targets) are taken in their order, `passes` times, from the weights w (units x
// (D + 1), bias last); gamma is the size of the steps.

// dw = gamma (d - y) phi'(s) x (B. Widrow and M. Hoff 1960): steepest descent of the squared error.
Eigen::MatrixXd delta_rule(Eigen::MatrixXd w, const Eigen::MatrixXd& X, const Eigen::MatrixXd& D, double gamma,
                           int passes, Activation activation = Activation::linear);

// dw = gamma (d - y) x with y = signum(s), targets -1 and 1 (F. Rosenblatt 1958). Ends when a whole pass is right.
struct PerceptronResult {
  Eigen::MatrixXd w;
  int passes = 0;
  bool separated = false;  // all samples are right
};
PerceptronResult perceptron_rule(Eigen::MatrixXd w, const Eigen::MatrixXd& X, const Eigen::MatrixXd& D, double gamma,
                                 int passes);

// Hebb's rule dw = gamma y x, y = w'x, without a target, in the normalised form dw = gamma y (x - y w) that does not
// diverge (E. Oja 1982): w tends to the first principal direction of the rows, which must have mean 0.
Eigen::VectorXd hebb_rule(Eigen::VectorXd w, const Eigen::MatrixXd& X, double gamma, int passes);

}  // namespace plantloop::identify
