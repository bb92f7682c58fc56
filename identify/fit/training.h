// Fitting the parameters of a model by steps downhill: what all trained models share.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "identify/fit/parallel.h"

namespace plantloop::identify {

// Sums of squared errors e = target - output as a function of the parameters, with J = d output/d theta.
class Training {
 public:
  virtual ~Training() = default;
  virtual Eigen::Index parameters() const = 0;
  virtual Eigen::Index targets() const = 0;  // how many errors
  // e'e; not finite where the output overflows.
  virtual double sse(const Eigen::VectorXd& theta) const = 0;
  // The same with R = J'J (all of it) and g = J'e.
  virtual double normal(const Eigen::VectorXd& theta, Eigen::MatrixXd& R, Eigen::VectorXd& g) const = 0;
};

enum class TrainingMethod { levenberg_marquardt, gauss_newton, back_propagation };
// By their names, "levenberg_marquardt", ...; raises IdentifyError.
TrainingMethod find_training_method(const std::string& name);
std::string name_of(TrainingMethod method);

// The criterion is V = (e'e + theta' D theta)/(2N), D = diag(decay), for N targets.
//
// levenberg_marquardt: (J'J + D + lambda I) h = J'e - D theta; with the predicted decrease L = h'g + h'(D + lambda I)h
//   of 2NV, lambda is halved when 2N(V - V_new) > 0.75 L and doubled when <= 0.25 L; only steps downhill are taken
//   (R. Fletcher 1971; M. Norgaard et al. 2000).
// gauss_newton: the step of least length (eigenvalues below 1e-12 of the greatest are left out), halved until it leads
//   downhill.
// back_propagation: theta -= rate * gradient of V, with momentum, and a rate that falls by 0.7 when V grows by more
//   than 4 % (such a step is taken back) and rises by 1.05 when it falls.
struct TrainingOptions {
  TrainingMethod method = TrainingMethod::levenberg_marquardt;
  int iterations = 500;
  double decay = 0;         // D of every parameter
  Eigen::VectorXd decays;   // of each parameter instead, when not empty
  double lambda = 1;        // the first one; above 1e7 the fit ends
  double gradient = 1e-9;   // ends when no element of J'e - D theta is greater
  double decrease = 1e-12;  // ends when V falls by less than this part of it
  double rate = 0.05;       // of back_propagation
  double momentum = 0.9;
  bool variable_rate = true;
  int patience = 20;        // with validation: iterations without improvement before the fit ends
  std::vector<bool> fixed;  // parameters that stay as they are, when not empty
};

struct TrainingResult {
  Eigen::VectorXd theta;
  double sse = 0;             // of the training data
  double validation_sse = 0;  // of the validation data, when there are any
  double criterion = 0;       // V
  int iterations = 0;
  std::string stopped;
  bool ill_conditioned = false;     // Gauss-Newton left directions out
  bool at_limit = false;            // of iterations, with more to gain
  double effective_parameters = 0;  // tr[R (R + D)^-1 R (R + D)^-1] at the end
};

// With `validation`, the parameters with the smallest validation error on the way are returned, and the fit ends early
// when that has not fallen for `patience` iterations. `watch` counts iterations.
TrainingResult train(const Training& training, const Eigen::VectorXd& start, const TrainingOptions& options,
                     Watch& watch, const Training* validation = nullptr);

// FPE = (N + g1)/(N + g1 - 2 g2) SSE/(2N) with H = R + D, g1 = tr(R H^-1 R H^-1), g2 = tr(R H^-1); for D = 0 Akaike's
// final prediction error over 2 (L. Ljung 1999; M. Norgaard et al. 2000).
double final_prediction_error(const Eigen::MatrixXd& R, const Eigen::VectorXd& decays, double sse, double targets);

}  // namespace plantloop::identify
