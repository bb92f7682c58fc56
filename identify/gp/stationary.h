// Covariances of the weighted distance: k(x, x') = v1 f(s), s = sum_d w_d (x_d - x'_d)^2.

#pragma once

#include <string>
#include <vector>

#include "identify/gp/covariance.h"

namespace plantloop::identify {

// Hyperparameters: w1..wD, v1, and those of the form. A form says what f and df/ds are; arrays are whole columns, so
// that loops over pairs are vectorised and nothing of size N x N x D is ever made.
class Stationary : public Covariance {
 public:
  using Array = Eigen::ArrayXd;

  std::vector<std::string> names(int inputs) const final;
  Vector guess(const Matrix& x, double variance) const final;
  Matrix between(const Vector& theta, const Matrix& x, const Matrix& z) const final;
  Matrix lower(const Vector& theta, const Matrix& x) const final;
  Vector at(const Vector& theta, const Matrix& x) const final;
  Vector gradient(const Vector& theta, const Matrix& x, const Matrix& values, const Matrix& weight) const final;
  Matrix input_gradient(const Vector& theta, const Vector& x, const Matrix& z) const final;
  Matrix slope_covariance(const Vector& theta, const Vector& x) const override;

 protected:
  // Replaces s by f(s). `own` are the hyperparameters of the form.
  virtual void shape(const Vector& own, Eigen::Ref<Array> s) const = 0;
  // df/ds from s and f.
  virtual void slope(const Vector& own, const Eigen::Ref<const Array>& s, const Eigen::Ref<const Array>& f,
                     Eigen::Ref<Array> result) const = 0;
  // Whether slope() reads s; if not, it is not computed again.
  virtual bool slope_reads_distance() const { return true; }
  // Of the form's own hyperparameters: names, start, and df/d log own_p.
  virtual std::vector<std::string> own_names() const { return {}; }
  virtual Vector own_guess() const { return {}; }
  virtual void own_slope(const Vector& own, int p, const Eigen::Ref<const Array>& s, const Eigen::Ref<const Array>& f,
                         Eigen::Ref<Array> result) const {
    (void)own, (void)p, (void)s, (void)f, (void)result;
  }
};

// The variance of each column; 1 where a column is constant.
Eigen::VectorXd column_variances(const Eigen::MatrixXd& x);

}  // namespace plantloop::identify
