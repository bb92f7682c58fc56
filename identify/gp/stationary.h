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
  Vector cross_gradient(const Vector& theta, const Matrix& x, const Matrix& z, const Matrix& values,
                        const Matrix& weight, Matrix* by_z) const final;
  Vector own_gradient(const Vector& theta, const Matrix& x, const Vector& weight) const final;
  Matrix input_gradient(const Vector& theta, const Vector& x, const Matrix& z) const final;
  Matrix slope_covariance(const Vector& theta, const Vector& x) const override;
  bool slopes(const Vector& theta, const Vector& x, const Vector& z, Matrix& block,
              std::vector<Matrix>* by_theta) const final;

 protected:
  // f and its derivatives by s up to the third. Those that grow beyond all bounds at s = 0, but not so that products
  // with the distances do, are 0 there.
  struct Series {
    double f = 0, f1 = 0, f2 = 0, f3 = 0;
  };
  // False: functions of this form have no slopes. `by_own` gets d f/d log own_p, of which f3 is not needed.
  virtual bool series(const Vector& own, double s, Series& f, std::vector<Series>& by_own) const {
    (void)own, (void)s, (void)f, (void)by_own;
    return false;
  }
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
