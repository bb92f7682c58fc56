// The squared exponential: very smooth functions, with a length scale for each input.

#include <cmath>

#include "identify/gp/gaussian_terms.h"
#include "identify/gp/stationary.h"

namespace plantloop::identify {
namespace {

// k = v1 exp(-1/2 sum_d w_d (x_d - x'_d)^2); the length scale of input d is 1/sqrt(w_d).
class SquaredExponential final : public Stationary {
 public:
  std::string name() const override { return "se_ard"; }

  bool terms(const Vector& theta, int inputs, std::vector<GaussianTerm>& list) const override {
    list.push_back({theta[inputs], theta.head(inputs), {}});
    return true;
  }

 protected:
  void shape(const Vector&, Eigen::Ref<Array> s) const override { s = (-0.5 * s).exp(); }
  void slope(const Vector&, const Eigen::Ref<const Array>&, const Eigen::Ref<const Array>& f,
             Eigen::Ref<Array> result) const override {
    result = -0.5 * f;
  }
  bool slope_reads_distance() const override { return false; }
  bool series(const Vector&, double s, Series& f, std::vector<Series>&) const override {
    const double e = std::exp(-0.5 * s);
    f = {e, -0.5 * e, 0.25 * e, -0.125 * e};
    return true;
  }
};

}  // namespace

PLANTLOOP_COVARIANCE(se_ard, SquaredExponential)

}  // namespace plantloop::identify
