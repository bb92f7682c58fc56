// Matern's form of order 5/2: functions with two derivatives.

#include <cmath>

#include "identify/gp/stationary.h"

namespace plantloop::identify {
namespace {

// k = v1 (1 + a + a^2/3) exp(-a), a = sqrt(5 s) (C. Rasmussen, C. Williams 2006, (4.17)).
class Matern52 final : public Stationary {
 public:
  std::string name() const override { return "matern_5_2"; }

 protected:
  void shape(const Vector&, Eigen::Ref<Array> s) const override {
    s = (5 * s).sqrt();
    s = (1 + s + s.square() / 3) * (-s).exp();
  }
  void slope(const Vector&, const Eigen::Ref<const Array>& s, const Eigen::Ref<const Array>&,
             Eigen::Ref<Array> result) const override {
    result = (5 * s).sqrt();
    result = -5.0 / 6 * (1 + result) * (-result).exp();
  }
  bool series(const Vector&, double s, Series& f, std::vector<Series>&) const override {
    const double a = std::sqrt(5 * s), e = std::exp(-a);
    f = {(1 + a + a * a / 3) * e, -5.0 / 6 * (1 + a) * e, 25.0 / 12 * e, a > 0 ? -125.0 / 24 * e / a : 0};
    return true;
  }
};

}  // namespace

PLANTLOOP_COVARIANCE(matern_5_2, Matern52)

}  // namespace plantloop::identify
