// Training a network together with a model of the noise: the prediction error method for NARMAX and NBJ.

#pragma once

#include <Eigen/Core>
#include <vector>

#include "identify/fit/training.h"
#include "identify/mlp/network.h"
#include "identify/narx/narx.h"

namespace plantloop::identify {

// For each output; see NarxModel.
struct NoiseOrders {
  int nc = 0, nd = 0;
  bool simulated = false;  // NBJ
};

// The parameters are those of the network, then c1 ... cnc, d1 ... dnd of each output. With g the map, s = y - g:
//   e(k) = s(k) + sum d_i s(k-i) - sum c_i e(k-i)
// and the derivatives go through time with it, from zeros before the first prediction of each experiment:
//   g'(k) = dg/dtheta + sum dg/de(k-i) e'(k-i) + sum dg/dg(k-i) g'(k-i)      (the last sum for NBJ)
//   e'(k) = -g'(k) - sum d_i g'(k-i) + s(k-i) [by d_i] - sum c_i e'(k-i) - e(k-i) [by c_i].
// Errors are normalised by the scale of the outputs. The error of a missing output is 0 and does not count.
class NoiseTraining final : public Training {
 public:
  // The data's inputs, and the outputs of the first samples, must not be missing. Raises IdentifyError.
  NoiseTraining(Network shape, Scaling x, Scaling y, RegressorSet regressors, const DataSet& data, NoiseOrders orders);
  Eigen::Index parameters() const override { return network_.parameters() + filters(); }
  Eigen::Index targets() const override { return targets_; }
  double sse(const Eigen::VectorXd& theta) const override;
  double normal(const Eigen::VectorXd& theta, Eigen::MatrixXd& R, Eigen::VectorXd& g) const override;

  // The errors of all experiments below each other, in units of the outputs: samples x outputs. For tests and starts;
  // `s`, when given, the parts that the map does not explain.
  Eigen::MatrixXd errors(const Eigen::VectorXd& theta, Eigen::MatrixXd* s = nullptr) const;
  // Of the filters' coefficients at theta, in its order: the block of H^-1 (sum J_k' S J_k) H^-1 with H = J'J +
  // diag(decays), J_k the derivatives of the outputs at sample k and S the covariance of the errors there, E'E/(samples
  // - effective parameters of each output). Directions of the network's weights that move no output are left out; a
  // coefficient that such a direction moves has infinite variance. Without filters it is empty.
  Eigen::MatrixXd covariance(const Eigen::VectorXd& theta, const Eigen::VectorXd& decays) const;
  // The filters that the end of theta stands for.
  NoiseFilters filters_of(const Eigen::VectorXd& theta) const;

 private:
  Eigen::Index filters() const { return (orders_.nc + orders_.nd) * network_.outputs(); }
  struct Run;
  // Calls row(errors, J) for each predicted sample: normalised errors, NaN where an output is missing, and in a column
  // of J for each output the derivatives of what is predicted, 0 where it is missing. The sum of squares, or infinity.
  template <typename Row>
  double sweep(const Eigen::VectorXd& theta, Row row) const;
  Network network_;
  Scaling x_, y_;
  RegressorSet regressors_;
  std::vector<Experiment> experiments_;  // with columns for the errors behind the inputs
  NoiseOrders orders_;
  Eigen::Index targets_ = 0;
};

}  // namespace plantloop::identify
