// Descent on the free variables of a box.

#include "identify/fit/minimise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

class Search {
 public:
  Search(const Objective& objective, const VectorXd& start, const MinimiseOptions& options)
      : objective_(objective), options_(options) {
    at_.x = clipped(start);
    at_.value = value(at_.x, at_.gradient);
  }

  Minimum run() {
    const Index n = at_.x.size();
    MatrixXd h = MatrixXd::Identity(n, n);  // the inverse of the curvature
    VectorXd direction, last_gradient;
    bool fresh = true;
    int small_steps = 0;
    if (!std::isfinite(at_.value)) return ended("the function is not defined at the start");
    while (true) {
      const VectorXd g = free_gradient();
      const double scale = std::max(1.0, std::fabs(at_.value));
      if (g.size() == 0 || g.cwiseAbs().maxCoeff() <= options_.gradient_tolerance * scale)
        return ended(fmt::format("the gradient is below {:g}", options_.gradient_tolerance * scale));
      if (at_.iterations >= options_.max_iterations)
        return ended(fmt::format("the limit of {} iterations was reached", options_.max_iterations));
      direction = next_direction(h, g, direction, last_gradient, fresh);
      const double before = at_.value;
      const VectorXd x = at_.x, gradient = at_.gradient;
      if (!step(direction, fresh)) {
        if (fresh) return ended("no step makes the value smaller");
        h.setIdentity();  // once more, from steepest descent
        fresh = true;
        continue;
      }
      ++at_.iterations;
      last_gradient = gradient;
      if (options_.method == Descent::quasi_newton) update(h, at_.x - x, at_.gradient - gradient, fresh);
      fresh = false;
      small_steps = before - at_.value <= options_.decrease_tolerance * scale ? small_steps + 1 : 0;
      if (small_steps == 3)
        return ended(fmt::format("three steps in a row gained less than {:g}", options_.decrease_tolerance * scale));
    }
  }

 private:
  double value(const VectorXd& x, VectorXd& gradient) {
    ++at_.evaluations;
    gradient.setZero(x.size());
    const double v = objective_(x, &gradient);
    return gradient.allFinite() ? v : std::numeric_limits<double>::infinity();
  }

  Minimum ended(std::string why) {
    at_.stop = std::move(why);
    return at_;
  }

  VectorXd clipped(VectorXd x) const {
    if (options_.lower.size() > 0) x = x.cwiseMax(options_.lower);
    if (options_.upper.size() > 0) x = x.cwiseMin(options_.upper);
    return x;
  }
  // At a bound and pushed against it.
  bool is_held(Index i, double slope) const {
    return (options_.lower.size() > 0 && at_.x[i] <= options_.lower[i] && slope > 0) ||
           (options_.upper.size() > 0 && at_.x[i] >= options_.upper[i] && slope < 0);
  }
  VectorXd free_gradient() const {
    VectorXd g = at_.gradient;
    for (Index i = 0; i < g.size(); ++i) {
      if (is_held(i, g[i])) g[i] = 0;
    }
    return g;
  }

  VectorXd next_direction(const MatrixXd& h, const VectorXd& g, const VectorXd& last, const VectorXd& last_gradient,
                          bool fresh) const {
    VectorXd d = -g;
    if (!fresh && options_.method == Descent::quasi_newton) {
      d = -(h * g);
    } else if (!fresh) {
      const double beta = at_.gradient.dot(at_.gradient - last_gradient) / last_gradient.squaredNorm();
      d = -g + std::max(0.0, beta) * last;
    }
    for (Index i = 0; i < d.size(); ++i) {
      if (is_held(i, at_.gradient[i])) d[i] = 0;
    }
    return d.dot(g) < 0 ? d : VectorXd(-g);
  }

  // The inverse update; left out where the curvature along the step is not positive.
  static void update(MatrixXd& h, const VectorXd& s, const VectorXd& y, bool fresh) {
    const double sy = s.dot(y);
    if (!(sy > 1e-12 * s.norm() * y.norm())) return;
    if (fresh) h *= sy / y.squaredNorm();
    const VectorXd hy = h * y;
    h += ((1 + y.dot(hy) / sy) / sy) * (s * s.transpose()) - (hy * s.transpose() + s * hy.transpose()) / sy;
  }

  // Goes along the direction to a point with enough decrease and enough change of slope; false: there is none.
  bool step(const VectorXd& direction, bool fresh) {
    const double slope = at_.gradient.dot(direction);
    const double flatter = options_.method == Descent::quasi_newton ? 0.9 : 0.1;
    double below = 0, above = std::numeric_limits<double>::infinity();
    double t = fresh ? std::min(1.0, 1 / direction.cwiseAbs().maxCoeff()) : 1;
    VectorXd best_x, best_gradient, gradient;
    double best = at_.value;
    for (int trial = 0; trial < 40; ++trial) {
      const VectorXd x = clipped(at_.x + t * direction);
      if (x == at_.x) break;
      const double v = value(x, gradient);
      const bool enough = std::isfinite(v) && v <= at_.value + 1e-4 * gradient_along(x) && v < at_.value;
      if (enough && v < best) best = v, best_x = x, best_gradient = gradient;
      if (!enough) {
        above = t;
      } else if (gradient.dot(direction) < flatter * slope && clipped(x + 1e-3 * t * direction) != x) {
        below = t;
      } else {
        break;
      }
      t = std::isinf(above) ? 2 * below : (below + above) / 2;
    }
    if (best_x.size() == 0) return false;
    at_.x = best_x;
    at_.value = best;
    at_.gradient = best_gradient;
    return true;
  }
  // Along the path that the bounds bend.
  double gradient_along(const VectorXd& x) const { return at_.gradient.dot(x - at_.x); }

  const Objective& objective_;
  const MinimiseOptions& options_;
  Minimum at_;
};

}  // namespace

Minimum minimise(const Objective& objective, const VectorXd& start, const MinimiseOptions& options) {
  return Search(objective, start, options).run();
}

}  // namespace plantloop::identify
