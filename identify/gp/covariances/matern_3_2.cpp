// Matern's form of order 3/2: functions with one derivative.

#include <cmath>

#include "identify/gp/stationary.h"

namespace plantloop::identify {
namespace {

// k = v1 (1 + a) exp(-a), a = sqrt(3 s) (C. Rasmussen, C. Williams 2006, (4.17)).
class Matern32 final : public Stationary {
 public:
  std::string name() const override { return "matern_3_2"; }

 protected:
  void shape(const Vector&, Eigen::Ref<Array> s) const override {
    s = (3 * s).sqrt();
    s = (1 + s) * (-s).exp();
  }
  void slope(const Vector&, const Eigen::Ref<const Array>& s, const Eigen::Ref<const Array>&,
             Eigen::Ref<Array> result) const override {
    result = -1.5 * (-(3 * s).sqrt()).exp();
  }
  bool series(const Vector&, double s, Series& f, std::vector<Series>&) const override {
    const double a = std::sqrt(3 * s), e = std::exp(-a);
    f = {(1 + a) * e, -1.5 * e, a > 0 ? 2.25 * e / a : 0, a > 0 ? -27.0 / 8 * e * (1 + a) / (a * a * a) : 0};
    return true;
  }
};

}  // namespace

PLANTLOOP_COVARIANCE(matern_3_2, Matern32)

}  // namespace plantloop::identify
