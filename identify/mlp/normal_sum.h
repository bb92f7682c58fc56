// Normal equations R = J'J, g = J'e summed block by block.

#pragma once

#include <Eigen/Core>

#include "identify/fit/parallel.h"

namespace plantloop::identify {

// Gradients of outputs are columns; J'J is added for a block of them at once.
class NormalSum {
 public:
  NormalSum(Eigen::Index parameters, Eigen::MatrixXd& R, Eigen::VectorXd& g)
      : columns_(parameters, block), errors_(block), r_(R), g_(g) {
    r_.setZero(parameters, parameters);
    g_.setZero(parameters);
  }
  // Where the next gradient goes.
  double* next() { return columns_.col(filled_).data(); }
  void add(double error) {
    errors_[filled_++] = error;
    if (filled_ == block) flush();
  }
  void finish() {
    flush();
    r_.triangularView<Eigen::StrictlyUpper>() = r_.transpose();
  }

 private:
  static constexpr Eigen::Index block = 192;
  void flush() {
    if (filled_ == 0) return;
    look_up();
    const auto full = columns_.leftCols(filled_);
    r_.selfadjointView<Eigen::Lower>().rankUpdate(full);
    g_.noalias() += full * errors_.head(filled_);
    filled_ = 0;
  }
  Eigen::MatrixXd columns_;
  Eigen::VectorXd errors_;
  Eigen::MatrixXd& r_;
  Eigen::VectorXd& g_;
  Eigen::Index filled_ = 0;
};

}  // namespace plantloop::identify
