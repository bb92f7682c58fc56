// Prediction at a point that is itself uncertain: x ~ N(mu, S).

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>

#include "identify/gp/gaussian_process.h"

namespace plantloop::identify {

struct UncertainPoint {
  Eigen::VectorXd mean;        // D
  Eigen::MatrixXd covariance;  // D x D; rows and columns of zeros for inputs that are known exactly
};

struct UncertainPrediction {
  double mean = 0;
  double variance = 0;    // of the function; a measurement adds v0
  Eigen::VectorXd slope;  // E of the mean's slope: D; cov(x, f) = S slope
};

enum class Propagation { naive, first_order, moment_matching };
// "naive", "first_order", "moment_matching"; throws IdentifyError.
Propagation find_propagation(const std::string& name);

// Predicts many times with one model; prepares what only depends on the model.
class Propagator {
 public:
  // Throws IdentifyError when the covariance has no closed moments and the method is moment_matching.
  Propagator(const GaussianProcess& model, Propagation method);

  // naive: S is ignored. first_order: mean m(mu), variance var(mu) + m'(mu)' S m'(mu), slope m'(mu).
  // moment_matching: the exact mean and variance of the mixture over x:
  //   m = beta' q,  variance = E k(x, x) - q' K^-1 q + tr((beta beta' - K^-1) C),  beta = K^-1 y,
  // with q = E k(x, X) and C = cov k(X, x) from Covariance::moments. With little noise beta and K^-1 are large, so C is
  // taken apart, C = G G', and the sum is |G' beta|^2 - |L^-1 G|^2 with the factor L of K.
  UncertainPrediction predict(const UncertainPoint& point) const;

 private:
  UncertainPrediction first_order(const UncertainPoint& point) const;
  UncertainPrediction moment_matching(const UncertainPoint& point) const;

  const GaussianProcess& model_;
  Propagation method_;
  Eigen::VectorXd whitened_;  // L' beta = L^-1 y
  Eigen::Index rank_ = 0;     // columns of G, at most
  Eigen::MatrixXd spread_;    // beta beta' - K^-1, for what is left of C
};

}  // namespace plantloop::identify
