// Prediction errors and their derivatives by filters.

#include "identify/linear/prediction_error.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "identify/linear/filter.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const VectorXd one = VectorXd::Ones(1);

Index order_of_F(const PolynomialModel& m) {
  Index order = 0;
  for (const VectorXd& f : m.F) order += f.size() - 1;
  return order;
}

// One experiment at given parameters.
class Errors {
 public:
  Errors(const PolynomialModel& m, const Experiment& e, std::size_t output, Initial initial)
      : m_(m),
        e_(e),
        at_level_(initial == Initial::rest && !m.integrates()),
        begin_(initial == Initial::rest ? 0 : std::min(first_determined(m), e.samples())),
        y_(e.y.col(static_cast<Index>(output))) {
    if (m.has_offset && at_level_) y_.array() -= m.offset / m.A.sum();
    s_ = filter(m.A, one, y_);
    if (m.has_offset && !at_level_) s_.array() -= m.offset;
    for (std::size_t i = 0; i < m.B.size(); ++i) {
      w_.push_back(filter(m.numerator(i), m.F[i], e.u.col(static_cast<Index>(i))));
      s_ -= w_[i];
    }
    s_.head(begin_).setZero();
    free_ = VectorXd::Zero(s_.size());
    v_ = filter(m.D, m.C, s_);
    if (initial == Initial::estimate) estimate();
  }

  const VectorXd& v() const { return v_; }

  MatrixXd jacobian() const {
    MatrixXd J(v_.size(), m_.parameters().size());
    Index column = 0;
    for (Index i = 1; i < m_.A.size(); ++i) J.col(column++) = noise(delayed(y_, i));
    for (std::size_t i = 0; i < m_.B.size(); ++i) {
      // The delay of -1 is a shift to the left, so the filter is applied to u and the columns are shifted by d + j.
      const VectorXd u = filter(one, m_.F[i], e_.u.col(static_cast<Index>(i)));
      for (Index j = 1; j <= m_.B[i].size(); ++j) J.col(column++) = -noise(delayed(u, m_.delay[i] + j));
    }
    const VectorXd by_c = filter(one, m_.C, v_), by_d = filter(one, m_.C, s_);
    for (Index i = 1; i < m_.C.size(); ++i) J.col(column++) = -delayed(by_c, i);
    for (Index i = 1; i < m_.D.size(); ++i) J.col(column++) = delayed(by_d, i);
    for (std::size_t i = 0; i < m_.B.size(); ++i) {
      const VectorXd own = filter(one, m_.F[i], w_[i]), past = filter(m_.D, multiply(m_.C, m_.F[i]), free_);
      for (Index j = 1; j < m_.F[i].size(); ++j) J.col(column++) = noise(delayed(own, j)) + delayed(past, j);
    }
    if (m_.has_offset) {
      const VectorXd constant = VectorXd::Ones(v_.size());
      if (!at_level_) {
        J.col(column) = -noise(constant);
      } else {
        // The level offset/A(1), at which the output was before the record, moves with the offset and with A.
        J.col(column) = -noise(filter(m_.A, one, constant)) / m_.A.sum();
        for (Index i = 0; i + 1 < m_.A.size(); ++i) J.col(i) -= J.col(column) * (m_.offset / m_.A.sum());
      }
    }
    if (responses_ > 0) project(J);
    return J;
  }

 private:
  // What part of s becomes in v.
  VectorXd noise(VectorXd part) const {
    part.head(begin_).setZero();
    return filter(m_.D, m_.C, part);
  }

  // Leaves what is orthogonal to all free responses.
  template <typename Columns>
  void project(Columns& columns) const {
    columns.applyOnTheLeft(qr_.householderQ().adjoint());
    columns.topRows(responses_).setZero();
    columns.applyOnTheLeft(qr_.householderQ());
  }

  void estimate() {
    const Index count = std::min(order_of_F(m_), v_.size() - begin_);
    if (count == 0) return;
    VectorXd all_F = one;
    for (const VectorXd& f : m_.F) all_F = multiply(all_F, f);
    const VectorXd h = delayed(impulse_response(one, all_F, v_.size()), begin_), in_v = filter(m_.D, m_.C, h);
    MatrixXd E(v_.size(), count);
    for (Index j = 0; j < count; ++j) E.col(j) = delayed(in_v, j);
    // A filter that explodes: the caller sees that v is not finite.
    if (!E.allFinite()) {
      v_.setConstant(HUGE_VAL);
      return;
    }
    VectorXd size;
    if (v_.allFinite()) {
      // E has ones below a triangle of zeros, so its columns never depend on each other.
      qr_.compute(E);
      size = qr_.solve(v_);
      responses_ = count;
      project(v_);
    } else {
      std::vector<Index> there;
      for (Index k = 0; k < v_.size(); ++k) {
        if (std::isfinite(v_[k])) there.push_back(k);
      }
      if (there.empty()) return;
      size = MatrixXd(E(there, Eigen::all)).completeOrthogonalDecomposition().solve(VectorXd(v_(there)));
      v_ -= E * size;
    }
    for (Index j = 0; j < count; ++j) free_ += size[j] * delayed(h, j);
    s_ -= free_;
  }

  const PolynomialModel& m_;
  const Experiment& e_;
  bool at_level_;
  Index begin_;
  VectorXd y_;               // about the level, from rest
  std::vector<VectorXd> w_;  // from rest
  VectorXd free_, s_, v_;
  Index responses_ = 0;
  Eigen::HouseholderQR<MatrixXd> qr_;
};

}  // namespace

Index first_determined(const PolynomialModel& m) {
  Index first = m.A.size() - 1;
  for (std::size_t i = 0; i < m.B.size(); ++i) {
    first = std::max(first, m.B[i].size() + m.delay[i] - (m.F[i].size() - 1));
  }
  return first;
}

Index values_of_the_past(const PolynomialModel& m, Index samples) {
  return std::min(samples, first_determined(m) + order_of_F(m));
}

VectorXd errors_of(const PolynomialModel& m, const Experiment& e, std::size_t output, Initial initial, MatrixXd* J) {
  const Errors errors(m, e, output, initial);
  if (J != nullptr) *J = errors.jacobian();
  return errors.v();
}

}  // namespace plantloop::identify
