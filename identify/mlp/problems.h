// What a network is trained for: static targets, one-step prediction, or simulation.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "identify/fit/training.h"
#include "identify/mlp/network.h"
#include "identify/regressors/regressors.h"

namespace plantloop::identify {

// Rows of normalised inputs (N x D) and targets (N x outputs).
class StaticTraining final : public Training {
 public:
  StaticTraining(Network shape, Eigen::MatrixXd x, const Eigen::MatrixXd& y);
  Eigen::Index parameters() const override { return network_.parameters(); }
  Eigen::Index targets() const override { return y_.size(); }
  double sse(const Eigen::VectorXd& theta) const override;
  double normal(const Eigen::VectorXd& theta, Eigen::MatrixXd& R, Eigen::VectorXd& g) const override;

 private:
  Network network_;
  Eigen::MatrixXd x_, y_;  // a column for each row of the data
};

// The free run: outputs of the model are fed back from the longest lag on, samples before that are the measured ones.
// Errors are normalised, and those of missing outputs do not count. Derivatives go through time,
//   S(k) = dg/dtheta + sum_i dg/dyhat(k-i) S(k-i),   S = 0 before the first sample.
class SimulationTraining final : public Training {
 public:
  // The data's inputs, and the outputs of the first samples, must not be missing.
  SimulationTraining(Network shape, Scaling x, Scaling y, RegressorSet regressors, const DataSet& data);
  Eigen::Index parameters() const override { return network_.parameters(); }
  Eigen::Index targets() const override { return targets_; }
  double sse(const Eigen::VectorXd& theta) const override;
  double normal(const Eigen::VectorXd& theta, Eigen::MatrixXd& R, Eigen::VectorXd& g) const override;

 private:
  Network network_;
  Scaling x_, y_;
  RegressorSet regressors_;
  std::vector<Experiment> experiments_;
  Eigen::Index targets_ = 0;
};

}  // namespace plantloop::identify
