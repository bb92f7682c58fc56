// Gaussian processes for large sets of data, seen through a few inducing inputs.

#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "identify/gp/posterior.h"

namespace plantloop::identify {

// What stands for p(y | X): with inducing inputs U, Q = K_fu K_uu^-1 K_uf and r = y - h'b
//
//   fitc  log N(r; 0, Q + diag(K_ff - Q) + v0 I)               (E. Snelson, Z. Ghahramani 2006)
//   vfe   log N(r; 0, Q + v0 I) - tr(K_ff - Q)/(2 v0)          (M. Titsias 2009): a lower bound of the exact one
enum class SparseMethod { fitc, vfe };
SparseMethod find_sparse_method(const std::string& name);  // "fitc", "vfe"; throws IdentifyError
std::string name_of(SparseMethod method);

// The value with its derivatives by log theta, log v0 and U. x: N x D, y: N, inducing: M x D; time grows with N M^2,
// memory with N M. Not defined: value -infinity.
Likelihood sparse_likelihood(SparseMethod method, const Covariance& covariance, MeanFunction mean,
                             const Hyperparameters& at, const Eigen::MatrixXd& x, const Eigen::VectorXd& y,
                             const Eigen::MatrixXd& inducing, bool with_gradient = true);

// Through two small Cholesky factors: with L L' = K_uu, V = L^-1 K_uf, G = diag(K_ff - Q) + v0 I (fitc) or v0 I (vfe),
//   B = I + V G^-1 V' = R R',  w = B^-1 V G^-1 r,  mean and variance as in posterior.h.
// With U = all inputs it is the exact process. L has the smallest sufficient jitter: none where K_uu is well
// conditioned, else 1e-12, 1e-11, ... 1e-5 times its mean diagonal.
class SparseGaussianProcess final : public GpPosterior {
 public:
  // x: N x D, y: N, inducing: M x D. Throws IdentifyError: data, hyperparameters, v0 = 0, K_uu singular.
  SparseGaussianProcess(SparseMethod method, std::shared_ptr<const Covariance> covariance, MeanFunction mean,
                        Hyperparameters hyperparameters, Eigen::MatrixXd x, Eigen::VectorXd y,
                        Eigen::MatrixXd inducing);
  // What is left of the data, as a model file has it.
  struct Content {
    SparseMethod method = SparseMethod::fitc;
    std::shared_ptr<const Covariance> covariance;
    MeanFunction mean = MeanFunction::zero;
    Hyperparameters hyperparameters;
    Eigen::MatrixXd inducing;           // U
    double jitter = 0;                  // of K_uu, relative to its mean diagonal
    Eigen::VectorXd mean_coefficients;  // b
    Eigen::VectorXd weights;            // w
    Eigen::MatrixXd precision;          // B
    long long samples = 0;
    double log_likelihood = 0;
  };
  explicit SparseGaussianProcess(Content content);

  double log_likelihood() const override { return content_.log_likelihood; }
  // These two need the data, which a model file does not hold. Throw IdentifyError.
  Likelihood likelihood() const override;
  // Of the approximation with its inducing inputs kept: from C = Q + G, mean_i = y_i - [C^-1 r]_i/[C^-1]_ii and
  // variance 1/[C^-1]_ii, for vfe with what Q lacks of K_ff besides.
  LeaveOneOut leave_one_out() const override;
  long long samples() const override { return content_.samples; }
  bool is_sparse() const override { return true; }
  void write(Item& item) const override;
  // With more measurements; U and the hyperparameters stay. Of a process from a file each is taken in by itself, which
  // is the same as all of them at once, but that the mean's coefficients stay, too.
  SparseGaussianProcess with(const Eigen::MatrixXd& x, const Eigen::VectorXd& y) const;

  SparseMethod method() const { return content_.method; }
  const Eigen::MatrixXd& inducing() const { return x_; }

 private:
  void prepare();

  struct Data {
    Eigen::MatrixXd x;
    Eigen::VectorXd y;
  };
  Content content_;                   // without what the posterior holds
  std::shared_ptr<const Data> data_;  // null: read from a file
  const Data& data(const char* what) const;
};

}  // namespace plantloop::identify
