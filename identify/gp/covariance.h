// Covariance functions of Gaussian processes.
//
// A Covariance is a form without numbers; its hyperparameters theta, all positive, come with each call, in the order of
// names(). Points are rows of X (N x D). Each file in covariances/ is one form, named like the file; a text combines
// them: "se_ard + linear", "se_ard * (periodic + linear)".

#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace plantloop::identify {

struct GaussianTerm;  // gaussian_terms.h

class Covariance {
 public:
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::MatrixXd;

  virtual ~Covariance() = default;
  // As a text that find_covariance reads.
  virtual std::string name() const = 0;
  // Of the hyperparameters, for D inputs.
  virtual std::vector<std::string> names(int inputs) const = 0;
  int count(int inputs) const { return static_cast<int>(names(inputs).size()); }
  // A sensible place to start, for outputs of the given variance.
  virtual Vector guess(const Matrix& x, double variance) const = 0;

  // k(x_i, z_j): rows(x) x rows(z).
  virtual Matrix between(const Vector& theta, const Matrix& x, const Matrix& z) const = 0;
  // The lower triangle of between(x, x); the upper one holds zeros.
  virtual Matrix lower(const Vector& theta, const Matrix& x) const = 0;
  // k(x_i, x_i).
  virtual Vector at(const Vector& theta, const Matrix& x) const = 0;
  // sum_ij weight_ij d k(x_i, x_j)/d log theta_p for each p. `weight` is symmetric; of it and of `values`, which is
  // lower(theta, x), only the lower triangles are read.
  virtual Vector gradient(const Vector& theta, const Matrix& x, const Matrix& values, const Matrix& weight) const = 0;
  // sum_ij weight_ij d k(x_i, z_j)/d log theta_p for each p, where `values` is between(theta, x, z). Unless it is null,
  // `by_z` (rows(z) x D) becomes sum_i weight_ij d k(x_i, z_j)/d z_j.
  virtual Vector cross_gradient(const Vector& theta, const Matrix& x, const Matrix& z, const Matrix& values,
                                const Matrix& weight, Matrix* by_z) const = 0;
  // sum_i weight_i d k(x_i, x_i)/d log theta_p for each p.
  virtual Vector own_gradient(const Vector& theta, const Matrix& x, const Vector& weight) const = 0;
  // d k(x, z_j)/d x: rows(z) x D.
  virtual Matrix input_gradient(const Vector& theta, const Vector& x, const Matrix& z) const = 0;
  // d^2 k(x, x)/dx dx' with the two arguments apart, at equal arguments: D x D; empty: the form has none.
  virtual Matrix slope_covariance(const Vector& theta, const Vector& x) const {
    (void)theta, (void)x;
    return {};
  }
  // The covariances of value and slopes at x with value and slopes at z, (1 + D) x (1 + D) with the values first:
  //   [k, dk/dz'; dk/dx, d2k/dx dz']
  // and, unless `by_theta` is null, their derivatives by log theta_p. False: the functions have no slopes.
  virtual bool slopes(const Vector& theta, const Vector& x, const Vector& z, Matrix& block,
                      std::vector<Matrix>* by_theta) const {
    (void)theta, (void)x, (void)z, (void)block, (void)by_theta;
    return false;
  }
  // Of points with this many columns; and how often v0 stands on the diagonal at each point. See slopes.h.
  virtual int inputs_of(Eigen::Index columns) const { return static_cast<int>(columns); }
  virtual Vector noise_weight(const Matrix& x) const { return Vector::Ones(x.rows()); }
  // Of a measurement at each point: v0, or the point's own.
  virtual Vector noise_variances(const Matrix& x, double v0) const { return Vector::Constant(x.rows(), v0); }
  // The form as a sum of Gaussians times affine factors, added to `list`: moment matching needs it. False: it is none.
  virtual bool terms(const Vector& theta, int inputs, std::vector<GaussianTerm>& list) const {
    (void)theta, (void)inputs, (void)list;
    return false;
  }
};

// A form that a file in covariances/ defines.
struct CovarianceType {
  std::string_view name;
  const Covariance& (*form)();
};
// All of them, sorted by name; made by CMake from the files' names.
const std::vector<CovarianceType>& covariances();

// The covariance that a text describes: names, `+`, `*` and parentheses. Throws IdentifyError.
std::shared_ptr<const Covariance> find_covariance(const std::string& text);

// Defines the form of a file.
#define PLANTLOOP_COVARIANCE(type_name, Class) \
  const Covariance& covariance_##type_name() { \
    static const Class form;                   \
    return form;                               \
  }

// "w" -> "w1", "w2", ... for each input.
std::vector<std::string> numbered(std::string_view name, int count);

}  // namespace plantloop::identify
