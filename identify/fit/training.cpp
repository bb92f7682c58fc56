// Levenberg-Marquardt, Gauss-Newton and back-propagation on normal equations.

#include "identify/fit/training.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "identify/error.h"

namespace plantloop::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr std::array<const char*, 3> method_names{"levenberg_marquardt", "gauss_newton", "back_propagation"};

class Trainer {
 public:
  Trainer(const Training& training, VectorXd start, const TrainingOptions& options, Watch& watch,
          const Training* validation)
      : training_(training), options_(options), watch_(watch), validation_(validation), theta_(std::move(start)) {
    decays_ = options.decays.size() > 0 ? options.decays : VectorXd::Constant(theta_.size(), options.decay);
    two_n_ = 2 * static_cast<double>(training.targets());
  }

  TrainingResult run() {
    const Watched watched(watch_);
    linearise();
    if (!std::isfinite(v_)) return result("the error at the start is not finite");
    look_at_validation();
    std::string why;
    while (why.empty()) {
      if (gradient_.size() == 0 || gradient_.cwiseAbs().maxCoeff() <= options_.gradient) {
        why = fmt::format("no element of the gradient is above {:g}", options_.gradient);
      } else if (done_ >= options_.iterations) {
        why = fmt::format("the limit of {} iterations was reached", options_.iterations);
        at_limit_ = true;
      } else {
        watch_.step();
        ++done_;
        why = iterate();
        if (why.empty()) why = look_at_validation();
      }
    }
    return result(why);
  }

 private:
  std::string iterate() {
    switch (options_.method) {
      case TrainingMethod::levenberg_marquardt:
        return marquardt();
      case TrainingMethod::gauss_newton:
        return gauss_newton();
      case TrainingMethod::back_propagation:
        return back_propagation();
    }
    return "nothing was asked for";
  }

  double criterion(double sse, const VectorXd& theta) const { return (sse + decays_.dot(theta.cwiseAbs2())) / two_n_; }
  // R, gradient and V at theta.
  void linearise() {
    sse_ = training_.normal(theta_, r_, g_);
    v_ = criterion(sse_, theta_);
    gradient_ = g_ - decays_.cwiseProduct(theta_);
    hold(gradient_);
  }
  // Zeros where parameters are fixed.
  void hold(VectorXd& change) const {
    for (std::size_t i = 0; i < options_.fixed.size(); ++i) {
      if (options_.fixed[i]) change[static_cast<Index>(i)] = 0;
    }
  }
  // R + D + lambda I, with the rows of fixed parameters those of the unit matrix.
  MatrixXd damped(double lambda) const {
    MatrixXd h = r_;
    h.diagonal() += decays_;
    h.diagonal().array() += lambda;
    for (std::size_t i = 0; i < options_.fixed.size(); ++i) {
      if (!options_.fixed[i]) continue;
      const auto at = static_cast<Index>(i);
      h.row(at).setZero();
      h.col(at).setZero();
      h(at, at) = 1;
    }
    return h;
  }
  // Goes to theta when that is downhill.
  bool accept(const VectorXd& theta, double sse) {
    const double v = criterion(sse, theta);
    if (!(v < v_)) return false;
    small_ = v_ - v <= options_.decrease * v_;
    theta_ = theta;
    linearise();
    return true;
  }
  std::string gained() const {
    return small_ ? fmt::format("an iteration gained less than {:g} of the criterion", options_.decrease) : "";
  }

  std::string marquardt() {
    const Eigen::LDLT<MatrixXd> factor(damped(lambda_));
    VectorXd h = factor.solve(gradient_);
    hold(h);
    const double predicted = h.dot(gradient_) + h.cwiseAbs2().dot((decays_.array() + lambda_).matrix());
    const VectorXd theta = theta_ + h;
    const double sse = h.allFinite() ? training_.sse(theta) : std::numeric_limits<double>::infinity();
    const double gain = two_n_ * (v_ - criterion(sse, theta));
    const double ratio = std::isfinite(gain) && predicted > 0 ? gain / predicted : -1;
    if (ratio > 0.75) lambda_ /= 2;
    if (ratio <= 0.25) lambda_ *= 2;
    const bool accepted = std::isfinite(sse) && accept(theta, sse);
    if (lambda_ > 1e7) return "no step leads downhill (lambda is above 1e7)";
    return accepted ? gained() : "";
  }

  std::string gauss_newton() {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> parts(damped(0));
    const VectorXd& values = parts.eigenvalues();
    const double least = 1e-12 * values[values.size() - 1];
    VectorXd h = parts.eigenvectors().transpose() * gradient_;
    for (Index i = 0; i < h.size(); ++i) {
      ill_conditioned_ = ill_conditioned_ || values[i] <= least;
      h[i] = values[i] > least ? h[i] / values[i] : 0;
    }
    h = parts.eigenvectors() * h;
    hold(h);
    for (int halving = 0; halving < 30; ++halving, h /= 2) {
      const VectorXd theta = theta_ + h;
      const double sse = training_.sse(theta);
      if (std::isfinite(sse) && accept(theta, sse)) return gained();
    }
    return "no step leads downhill";
  }

  std::string back_propagation() {
    if (step_.size() == 0) step_ = VectorXd::Zero(theta_.size());
    if (rate_ == 0) rate_ = options_.rate;
    step_ = options_.momentum * step_ + rate_ * 2 / two_n_ * gradient_;
    const VectorXd before = theta_;
    const double v_before = v_;
    theta_ += step_;
    const double v = criterion(training_.sse(theta_), theta_);
    if (options_.variable_rate && !(v <= 1.04 * v_before)) {
      theta_ = before;
      rate_ *= 0.7;
      step_.setZero();
      return rate_ < 1e-15 ? "no step leads downhill" : "";
    }
    if (!std::isfinite(v)) {
      theta_ = before;
      return "the error grew beyond all bounds; a smaller rate is needed";
    }
    if (options_.variable_rate && v < v_before) rate_ *= 1.05;
    linearise();
    return "";
  }

  // Keeps the parameters that are best on the validation data.
  std::string look_at_validation() {
    if (validation_ == nullptr) return "";
    const double error = validation_->sse(theta_);
    if (best_theta_.size() == 0 || error < best_validation_) {
      best_validation_ = error;
      best_theta_ = theta_;
      best_at_ = done_;
    }
    if (done_ - best_at_ < options_.patience) return "";
    return fmt::format("the validation error has not fallen for {} iterations", options_.patience);
  }

  TrainingResult result(std::string why) {
    if (best_theta_.size() > 0 && best_theta_ != theta_) {
      theta_ = best_theta_;
      linearise();
    }
    TrainingResult end;
    end.theta = theta_;
    end.sse = sse_;
    end.validation_sse = best_validation_;
    end.criterion = v_;
    end.iterations = done_;
    end.stopped = std::move(why);
    end.ill_conditioned = ill_conditioned_;
    end.at_limit = at_limit_;
    if (std::isfinite(v_)) {
      const MatrixXd part = Eigen::LDLT<MatrixXd>(damped(1e-300)).solve(r_);
      end.effective_parameters = (part.array() * part.transpose().array()).sum();
    }
    return end;
  }

  const Training& training_;
  const TrainingOptions& options_;
  Watch& watch_;
  const Training* validation_;
  VectorXd theta_, decays_, g_, gradient_, step_, best_theta_;
  MatrixXd r_;
  double two_n_ = 1, sse_ = 0, v_ = 0, lambda_ = options_.lambda, rate_ = 0, best_validation_ = 0;
  int done_ = 0, best_at_ = 0;
  bool small_ = false, ill_conditioned_ = false, at_limit_ = false;
};

}  // namespace

TrainingMethod find_training_method(const std::string& name) {
  for (std::size_t i = 0; i < method_names.size(); ++i) {
    if (name == method_names[i]) return static_cast<TrainingMethod>(i);
  }
  fail("there is no training method '{}'; there are {}", name, fmt::join(method_names, ", "));
}

std::string name_of(TrainingMethod method) { return method_names[static_cast<std::size_t>(method)]; }

TrainingResult train(const Training& training, const VectorXd& start, const TrainingOptions& options, Watch& watch,
                     const Training* validation) {
  return Trainer(training, start, options, watch, validation).run();
}

double final_prediction_error(const MatrixXd& R, const VectorXd& decays, double sse, double targets) {
  const MatrixXd h = R + MatrixXd(decays.asDiagonal());
  const MatrixXd part = h.completeOrthogonalDecomposition().solve(R);
  const double g1 = (part.array() * part.transpose().array()).sum(), g2 = part.trace();
  const double rest = targets + g1 - 2 * g2;
  if (!(rest > 0)) return std::numeric_limits<double>::infinity();
  return (targets + g1) / rest * sse / (2 * targets);
}

}  // namespace plantloop::identify
