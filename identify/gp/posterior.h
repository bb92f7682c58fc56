// What a Gaussian process knows after its data: predictions anywhere, with how certain they are.

#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "identify/gp/covariance.h"
#include "identify/model_file/item.h"

namespace plantloop::identify {

// What is assumed far from all data. Its coefficients are the maximum-likelihood ones for the hyperparameters (the
// generalised least-squares estimate) and are taken as known afterwards.
enum class MeanFunction { zero, constant, linear };
MeanFunction find_mean_function(const std::string& name);  // "zero", "constant", "linear"; throws IdentifyError
std::string name_of(MeanFunction mean);
// The regressors of the mean: N x 0, N x 1 or N x (1 + D).
Eigen::MatrixXd mean_basis(MeanFunction mean, const Eigen::MatrixXd& x);

struct Hyperparameters {
  Eigen::VectorXd theta;  // of the covariance, in the order of its names; all positive
  double v0 = 0;          // variance of the white noise of each target
};
// Throws IdentifyError: their number, one that is not positive, v0 below 0.
void check_hyperparameters(const Covariance& covariance, int inputs, const Hyperparameters& at);

// A log likelihood and its derivatives with respect to the logarithms of theta and, last, of v0.
struct Likelihood {
  double value = 0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd by_inducing;  // of a sparse process: by its inducing inputs, M x D
};

// Of each predicted point.
struct Prediction {
  Eigen::VectorXd mean;
  Eigen::VectorXd variance;  // of the function itself; that of a measurement adds the noise v0
};

// Each target predicted from all the others, with the hyperparameters kept; variances are with the noise.
struct LeaveOneOut {
  Eigen::VectorXd mean;
  Eigen::VectorXd variance;
  Eigen::VectorXd log_density;  // log p(y_i | the others)
  double log_probability = 0;   // their sum
};
// log N(y_i; mean_i, variance_i).
Eigen::VectorXd log_densities(const Eigen::VectorXd& y, const Eigen::VectorXd& mean, const Eigen::VectorXd& variance);

// The function is seen through M points Z with covariances K = L L':
//   mean(x) = h(x)'b + k'beta,  variance(x) = k(x, x) - k'P k,  k = k(Z, x),
//   beta = L'^-1 w,  P = L'^-1 (I - S) L^-1,
// where an exact process has Z = X, S = 0 and w = L^-1 (y - h'b), and a sparse one the inducing inputs Z = U and the
// posterior N(w, S), S = (R R')^-1, of L^-1 f(U).
class GpPosterior {
 public:
  virtual ~GpPosterior() = default;

  Prediction predict(const Eigen::MatrixXd& x) const;            // rows x D
  Eigen::VectorXd predict_mean(const Eigen::MatrixXd& x) const;  // the means alone
  // The mean's slope at a point (D), and that of the variance.
  Eigen::VectorXd mean_gradient(const Eigen::VectorXd& x) const;
  Eigen::VectorXd variance_gradient(const Eigen::VectorXd& x) const;
  // A'beta (A: M x any), tr(B'P B) from L^-1 B, and P (M x M).
  Eigen::VectorXd weighted(Eigen::MatrixXd a) const;
  double known(Eigen::MatrixXd whitened) const;
  Eigen::MatrixXd precision() const;

  // log p(y | X), of a variational process its lower bound; and with the gradient.
  virtual double log_likelihood() const = 0;
  virtual Likelihood likelihood() const = 0;
  virtual LeaveOneOut leave_one_out() const = 0;
  // How many targets it was made of.
  virtual long long samples() const = 0;
  virtual bool is_sparse() const { return false; }
  // Adds what a model file says of it.
  virtual void write(Item& item) const = 0;

  const Covariance& covariance() const { return *covariance_; }
  std::shared_ptr<const Covariance> shared_covariance() const { return covariance_; }
  MeanFunction mean_function() const { return mean_; }
  const Eigen::VectorXd& mean_coefficients() const { return coefficients_; }
  const Hyperparameters& hyperparameters() const { return hyperparameters_; }
  int inputs() const { return covariance_->inputs_of(x_.cols()); }
  const Eigen::MatrixXd& x() const { return x_; }                // Z
  const Eigen::VectorXd& alpha() const { return alpha_; }        // beta
  const Eigen::VectorXd& whitened() const { return whitened_; }  // w
  const Eigen::MatrixXd& factor() const { return factor_; }      // L in its lower triangle
  const Eigen::MatrixXd& inner() const { return inner_; }        // R in its lower triangle; empty: S = 0
  double jitter() const { return jitter_; }                      // on the diagonal of K

 protected:
  GpPosterior(std::shared_ptr<const Covariance> covariance, MeanFunction mean, Hyperparameters hyperparameters,
              Eigen::MatrixXd x);
  GpPosterior(const GpPosterior&) = default;
  GpPosterior(GpPosterior&&) = default;
  GpPosterior& operator=(const GpPosterior&) = default;
  GpPosterior& operator=(GpPosterior&&) = default;
  // Adds the means h(x)'b.
  void add_mean(const Eigen::MatrixXd& x, Eigen::VectorXd& values) const;
  // Sets `factor_` to that of `k` with the smallest sufficient jitter of `least`, 10 least, ... `most` times its mean
  // diagonal; with least = 0 none is tried first, then 1e-12. False: there is none.
  bool factorise_with_jitter(const Eigen::MatrixXd& k, double least, double most);

  std::shared_ptr<const Covariance> covariance_;
  MeanFunction mean_;
  Hyperparameters hyperparameters_;
  Eigen::MatrixXd x_;
  Eigen::VectorXd coefficients_, alpha_, whitened_;
  Eigen::MatrixXd factor_, inner_;
  double jitter_ = 0;
};

// Throws IdentifyError when a number is not finite, the sizes differ or there are no rows.
void check_data(const Eigen::MatrixXd& x, const Eigen::VectorXd& y);

}  // namespace plantloop::identify
