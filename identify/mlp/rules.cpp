// Delta rule, perceptron rule and Hebb's rule.

#include "identify/mlp/rules.h"

#include "identify/error.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void check(const MatrixXd& w, const MatrixXd& X, const MatrixXd& D, double gamma) {
  if (X.rows() == 0 || X.rows() != D.rows() || w.cols() != X.cols() + 1 || w.rows() != D.cols())
    fail("samples of {} x {} with targets of {} x {} need {} x {} weights, there are {} x {}", X.rows(), X.cols(),
         D.rows(), D.cols(), D.cols(), X.cols() + 1, w.rows(), w.cols());
  if (!(gamma > 0)) fail("the step gamma is {:g}; it must be greater than 0", gamma);
}

}  // namespace

MatrixXd delta_rule(MatrixXd w, const MatrixXd& X, const MatrixXd& D, double gamma, int passes, Activation activation) {
  check(w, X, D, gamma);
  if (activation == Activation::signum)
    fail("the delta rule needs a slope, and signum has none; use the perceptron rule");
  VectorXd x(X.cols() + 1);
  for (int pass = 0; pass < passes; ++pass) {
    for (Index k = 0; k < X.rows(); ++k) {
      x << X.row(k).transpose(), 1;
      const VectorXd s = w * x;
      for (Index i = 0; i < w.rows(); ++i) {
        const double h = activate(activation, s[i]);
        w.row(i) += gamma * (D(k, i) - h) * slope(activation, s[i], h) * x.transpose();
      }
    }
  }
  return w;
}

PerceptronResult perceptron_rule(MatrixXd w, const MatrixXd& X, const MatrixXd& D, double gamma, int passes) {
  check(w, X, D, gamma);
  PerceptronResult result{std::move(w), 0, false};
  VectorXd x(X.cols() + 1);
  while (result.passes < passes && !result.separated) {
    ++result.passes;
    result.separated = true;
    for (Index k = 0; k < X.rows(); ++k) {
      x << X.row(k).transpose(), 1;
      const VectorXd s = result.w * x;
      for (Index i = 0; i < s.size(); ++i) {
        const double error = D(k, i) - activate(Activation::signum, s[i]);
        result.separated = result.separated && error == 0;
        result.w.row(i) += gamma * error * x.transpose();
      }
    }
  }
  return result;
}

VectorXd hebb_rule(VectorXd w, const MatrixXd& X, double gamma, int passes) {
  if (X.rows() == 0 || w.size() != X.cols())
    fail("samples of {} numbers need as many weights, there are {}", X.cols(), w.size());
  if (!(gamma > 0)) fail("the step gamma is {:g}; it must be greater than 0", gamma);
  for (int pass = 0; pass < passes; ++pass) {
    for (Index k = 0; k < X.rows(); ++k) {
      const VectorXd x = X.row(k).transpose();
      const double y = w.dot(x);
      w += gamma * y * (x - y * w);
    }
  }
  return w;
}

}  // namespace plantloop::identify
