// The rational quadratic: a mixture of squared exponentials of many length scales.

#include "identify/gp/stationary.h"

namespace plantloop::identify {
namespace {

// k = v1 (1 + s/(2 alpha))^-alpha (C. Rasmussen, C. Williams 2006, (4.19)).
class RationalQuadratic final : public Stationary {
 public:
  std::string name() const override { return "rational_quadratic"; }

 protected:
  void shape(const Vector& own, Eigen::Ref<Array> s) const override {
    s = (-own[0] * (s / (2 * own[0])).log1p()).exp();
  }
  void slope(const Vector& own, const Eigen::Ref<const Array>& s, const Eigen::Ref<const Array>& f,
             Eigen::Ref<Array> result) const override {
    result = -0.5 * f / (1 + s / (2 * own[0]));
  }
  std::vector<std::string> own_names() const override { return {"alpha"}; }
  Vector own_guess() const override { return Vector::Constant(1, 2.0); }
  void own_slope(const Vector& own, int, const Eigen::Ref<const Array>& s, const Eigen::Ref<const Array>& f,
                 Eigen::Ref<Array> result) const override {
    const double alpha = own[0];
    result = f * (0.5 * s / (1 + s / (2 * alpha)) - alpha * (s / (2 * alpha)).log1p());
  }
  // With q = 1 + s/(2 alpha): f = q^-alpha, f' = -f/(2 q), f'' = (alpha + 1)/(4 alpha) f/q^2.
  bool series(const Vector& own, double s, Series& f, std::vector<Series>& by_own) const override {
    const double alpha = own[0], q = 1 + s / (2 * alpha), p = std::exp(-alpha * std::log1p(s / (2 * alpha)));
    f = {p, -0.5 * p / q, (alpha + 1) / (4 * alpha) * p / (q * q),
         -(alpha + 1) * (alpha + 2) / (8 * alpha * alpha) * p / (q * q * q)};
    // dq/d log alpha = 1 - q, and of f as own_slope() has it.
    const double dp = p * (q - 1) / q * alpha - p * alpha * std::log1p(s / (2 * alpha)), dq = 1 - q;
    by_own[0] = {dp, -0.5 * (dp - p * dq / q) / q,
                 ((alpha + 1) / (4 * alpha) * (dp - 2 * p * dq / q) - p / (4 * alpha)) / (q * q), 0};
    return true;
  }
};

}  // namespace

PLANTLOOP_COVARIANCE(rational_quadratic, RationalQuadratic)

}  // namespace plantloop::identify
