// Free runs of networks in state space, and their derivatives forwards in time.

#include "identify/neural_state_space/state_space_training.h"

#include <cmath>
#include <limits>

#include "identify/error.h"
#include "identify/mlp/normal_sum.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
// Of the square of a state whose mean square was about 1; what grows beyond all bounds need not be followed to its end.
constexpr double runaway = 1e8;

}  // namespace

StateSpaceTraining::StateSpaceTraining(Network transition, Network output, std::vector<Experiment> experiments)
    : transition_(std::move(transition)), output_(std::move(output)), experiments_(std::move(experiments)) {
  for (const Experiment& e : experiments_) {
    if (!e.u.allFinite()) fail("training for simulation needs every input; values are missing");
    targets_ += e.y.array().isFinite().count();
  }
  if (targets_ == 0) fail("there is no measured output to train on");
}

Index StateSpaceTraining::parameters() const {
  return transition_.parameters() + output_.parameters() +
         transition_.outputs() * static_cast<Index>(experiments_.size());
}

double StateSpaceTraining::sse(const VectorXd& theta) const {
  Network f = transition_, g = output_;
  const Index n = f.outputs(), of_f = f.parameters(), of_g = g.parameters(), inputs = f.inputs() - n;
  f.set_theta(theta.head(of_f));
  g.set_theta(theta.segment(of_f, of_g));
  VectorXd scratch(std::max(f.scratch_size(), g.scratch_size())), z(n + inputs), x(n), y(g.outputs());
  double sum = 0;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    const Experiment& e = experiments_[i];
    x = theta.segment(of_f + of_g + n * static_cast<Index>(i), n);
    for (Index k = 0; k < e.samples(); ++k) {
      z.head(n) = x;
      z.tail(inputs) = e.u.row(k).transpose();
      g.evaluate(z.data(), y.data(), scratch.data());
      for (Index o = 0; o < y.size(); ++o) {
        if (std::isfinite(e.y(k, o))) sum += std::pow(e.y(k, o) - y[o], 2);
      }
      f.evaluate(z.data(), x.data(), scratch.data());
      if (!(x.squaredNorm() < runaway)) return infinite;
    }
  }
  return sum;
}

double StateSpaceTraining::normal(const VectorXd& theta, MatrixXd& R, VectorXd& gradient) const {
  Network f = transition_, g = output_;
  const Index n = f.outputs(), of_f = f.parameters(), of_g = g.parameters(), inputs = f.inputs() - n,
              outputs = g.outputs(), all = parameters();
  f.set_theta(theta.head(of_f));
  g.set_theta(theta.segment(of_f, of_g));
  VectorXd scratch(std::max(f.scratch_size(), g.scratch_size())), z(n + inputs), x(n), y(outputs);
  MatrixXd f_theta(of_f, n), f_z(n + inputs, n), g_theta(of_g, outputs), g_z(g.inputs(), outputs);
  // Derivatives of the state by the transition's weights and by the first state; the output's weights do not move it.
  MatrixXd by(of_f + n, n), next(of_f + n, n);
  NormalSum sum(all, R, gradient);
  double sse = 0;
  for (std::size_t i = 0; i < experiments_.size(); ++i) {
    const Experiment& e = experiments_[i];
    const Index start = of_f + of_g + n * static_cast<Index>(i);
    x = theta.segment(start, n);
    by.setZero();
    by.bottomRows(n).setIdentity();
    for (Index k = 0; k < e.samples(); ++k) {
      z.head(n) = x;
      z.tail(inputs) = e.u.row(k).transpose();
      g.differentiate(z.data(), y.data(), g_theta.data(), g_z.data(), scratch.data());
      for (Index o = 0; o < outputs; ++o) {
        if (!std::isfinite(e.y(k, o))) continue;
        const double error = e.y(k, o) - y[o];
        sse += error * error;
        auto row = VectorXd::Map(sum.next(), all);
        row.tail(all - of_f - of_g).setZero();
        row.head(of_f).noalias() = by.topRows(of_f) * g_z.col(o).head(n);
        row.segment(of_f, of_g) = g_theta.col(o);
        row.segment(start, n).noalias() = by.bottomRows(n) * g_z.col(o).head(n);
        sum.add(error);
      }
      f.differentiate(z.data(), x.data(), f_theta.data(), f_z.data(), scratch.data());
      next.noalias() = by * f_z.topRows(n);
      next.topRows(of_f) += f_theta;
      by.swap(next);
      if (!(x.squaredNorm() < runaway)) return infinite;
    }
  }
  sum.finish();
  if (!std::isfinite(sse) || !R.allFinite() || !gradient.allFinite()) return infinite;
  return sse;
}

}  // namespace plantloop::identify
