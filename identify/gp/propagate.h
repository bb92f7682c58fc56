// Prediction at a point that is itself uncertain: x ~ N(mu, S).

#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "identify/gp/gaussian_process.h"
#include "identify/gp/gaussian_terms.h"
#include "identify/gp/hermite.h"
#include "identify/gp/posterior.h"

namespace plantloop::identify {

// Raises IdentifyError: sizes, numbers that are not finite, a covariance that is not symmetric or negative somewhere.
void check_point(const UncertainPoint& point, int inputs);

// Of m functions of one x. Given x they are independent; that x is uncertain makes them depend on each other.
struct UncertainPrediction {
  Eigen::VectorXd mean;        // m
  Eigen::MatrixXd covariance;  // m x m, of the functions; a measurement adds v0 to the diagonal
  Eigen::MatrixXd slope;       // E of the means' slopes, one row for each function: m x D; cov(f, x) = slope S
};

enum class Propagation { naive, first_order, moment_matching };
// "naive", "first_order", "moment_matching"; throws IdentifyError.
Propagation find_propagation(const std::string& name);

// Predicts many times with the same models; prepares what only depends on them. They must live as long.
class Propagator {
 public:
  // One model for each function, of the same inputs. Throws IdentifyError when a covariance has no closed moments and
  // the method is moment_matching.
  Propagator(const std::vector<std::shared_ptr<const GpPosterior>>& models, Propagation method);
  Propagator(const std::vector<GaussianProcess>& models, Propagation method);

  // naive: S is ignored, slopes and covariances are 0. first_order: with J = the means' slopes at mu, mean m(mu),
  // covariance diag(var(mu)) + J S J', slope J.
  // moment_matching: the exact mean and covariance of the mixture over x (M. Deisenroth, C. Rasmussen 2011):
  //   m_a = beta_a' q_a,  cov_ab = beta_a' C_ab beta_b,
  //   var_a = E k_a(x, x) - q_a' P_a q_a + tr((beta_a beta_a' - P_a) C_aa),
  // with q_a = E k_a(x, Z_a) and C_ab = cov(k_a(Z_a, x), k_b(x, Z_b)), and beta, P, Z, L, w of posterior.h. With little
  // noise beta and P are large, so C of all models together is taken apart, C = G G', and with the factors L
  //   cov_ab = (L_a^-1 G_a)'w_a . (L_b^-1 G_b)'w_b,
  //   var_a  = k - q'P q + |(L^-1 G)'w|^2 - tr(G'P G).
  // G begins with a series in Hermite's polynomials: where functions are known almost exactly, beta makes much of what
  // is far below the rounding of C. Where the series is too long, C is taken apart for what it leaves.
  UncertainPrediction predict(const UncertainPoint& point) const;

 private:
  UncertainPrediction first_order(const UncertainPoint& point) const;
  UncertainPrediction moment_matching(const UncertainPoint& point) const;
  // The columns of the series; `converged`: there is no more.
  Eigen::MatrixXd series(const std::vector<KernelMoments>& moments, bool& converged) const;
  void add_rest(const std::vector<std::vector<KernelPairs>>& pairs, const Eigen::MatrixXd& G,
                Eigen::MatrixXd& covariance) const;

  Propagator(std::vector<const GpPosterior*> models, Propagation method);

  std::vector<const GpPosterior*> models_;
  Propagation method_;
  std::vector<std::vector<GaussianTerm>> terms_;  // of each covariance
  std::vector<MultiIndices> indices_;             // of 1, 2, ... uncertain directions
  std::vector<Eigen::Index> first_;               // where each model begins in G; last, its rows
  Eigen::Index rank_ = 0;                         // columns of G, at most
  std::vector<Eigen::MatrixXd> spread_;           // beta beta' - P, for what is left of C; empty: nothing ever is
};

}  // namespace plantloop::identify
