// The error of a neural state-space model's free run as a function of its weights.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "identify/data/data_set.h"
#include "identify/fit/training.h"
#include "identify/mlp/network.h"

namespace plantloop::identify {

// theta: the weights of the transition, those of the output, then the first state of each experiment. All numbers are
// normalised; outputs that are NaN do not count. Derivatives are carried along with the state:
//   dx(k+1)/dtheta = (df/dx) dx(k)/dtheta + df/dtheta,   dy/dtheta = (dg/dx) dx/dtheta + dg/dtheta.
class StateSpaceTraining final : public Training {
 public:
  // `output` has as many inputs as there are states, or as states and inputs together.
  StateSpaceTraining(Network transition, Network output, std::vector<Experiment> experiments);

  Eigen::Index parameters() const override;
  Eigen::Index targets() const override { return targets_; }
  double sse(const Eigen::VectorXd& theta) const override;
  double normal(const Eigen::VectorXd& theta, Eigen::MatrixXd& R, Eigen::VectorXd& g) const override;

 private:
  Network transition_, output_;
  std::vector<Experiment> experiments_;
  Eigen::Index targets_ = 0;
};

}  // namespace plantloop::identify
