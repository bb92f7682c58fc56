// Parameters that are estimated while the plant runs.
//
// L. Ljung, System Identification, 2nd edition 1999, section 11.2; book section 2.1.

#include <fmt/format.h>

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct RecursiveLeastSquares final : Block {
  static constexpr auto summary = "Estimate the parameters of a linear regression from sample to sample.";
  static constexpr auto details =
      "Of y[k] = phi[k]' theta + v[k]:  error = y - phi' theta-,  K = P- phi/(forgetting + phi' P- phi),  theta = "
      "theta- + K error,  P = (P- - K phi' P-)/forgetting.  With a forgetting below 1 a sample counts half after "
      "log(0.5)/log(forgetting) further ones.  Two safeguards for loops that run on: while the error is within the "
      "dead_zone nothing is learned, and while the trace of P would exceed max_trace nothing is forgotten, as it does "
      "when the regressors tell nothing new.  Regressors such as y[k-1] come from unit delays or tapped_delay; with "
      "enable: the estimate rests.";
  static constexpr auto example = R"(
title: Gain and pole of a sampled lag, y[k+1] = 0.8 y[k] + 0.5 u[k]
blocks:
  u: {type: prbs, amplitude: 1, rate: 1}
  y: {type: unit_delay, in: 0.8*y + 0.5*u, rate: 1}
  before: {type: unit_delay, in: "[y, u]", initial: "[0, 0]", rate: 1}
  plant: {type: recursive_least_squares, in: {y: y, phi: before}}
simulation: {stop: 60}
expect:
  - {signal: plant.theta.1, measure: final, value: 0.8, abs: 1e-4}
  - {signal: plant.theta.2, measure: final, value: 0.5, abs: 1e-4}
)";

  Input y{this, "y", {.doc = "what is measured", .size = scalar}};
  Input phi{this, "phi", {.doc = "regressors, one for each parameter", .size = any_size}};
  Number forgetting{
      this,
      "forgetting",
      {.init = 1, .doc = "what the weight of a sample is multiplied by at the next", .max = 1, .above = 0}};
  Table P0{
      this, "P", {.init = "1e4", .doc = "covariance of the error of `initial`: n by n, its diagonal, or one number"}};
  Table initial_value{
      this,
      "initial",
      {.init = "0", .doc = "parameters at the start, n numbers or one for all; may read signals", .initial = true}};
  Number dead_zone{this, "dead_zone", {.init = 0, .doc = "errors up to this one teach nothing", .min = 0}};
  Number max_trace{this,
                   "max_trace",
                   {.doc = "greatest sum of the variances in P; default: no limit", .above = 0, .optional = true}};
  Discrete estimate{this, "estimate", {.doc = "the parameters before the present sample", .size = any_size}};
  Discrete covariance{this, "covariance", {.doc = "P before it", .size = any_size}};
  Output theta{this, "theta", {.doc = "the parameters, with the present sample", .size = any_size}};
  Output error{this, "error", {.doc = "y less what was expected of it before"}};
  Output P{
      this, "P", {.doc = "covariance of the parameters' error, where the noise has the variance 1", .size = any_size}};

  void sizes(Sizing& sizing) const override {
    const Shape regressors = sizing.of(phi);
    if (!regressors.is_known()) return;
    const int n = regressors.size();
    const Shape one_or_many = n == 1 ? Shape::scalar() : Shape::vector(n);
    sizing.set(estimate, Shape::vector(n));
    sizing.set(covariance, Shape::matrix(n, n));
    sizing.set(theta, one_or_many);
    sizing.set(P, n == 1 ? Shape::scalar() : Shape::matrix(n, n));
    const Shape start = sizing.of(initial_value);
    if (start.is_known() && start.size() != 1 && start.size() != n)
      sizing.problem(initial_value, fmt::format("initial must have {} elements, one for each regressor, but it is {}",
                                                n, to_string(start)));
    check_covariance(sizing, P0, n);
  }

  void initial(Now now, Init init) const override {
    init[estimate] = now[initial_value];
    init[covariance] = full_covariance(now[P0], now[phi].size());
  }
  void outputs(Now now, Out out) const override {
    const Learned learned = learn(now);
    out[theta] = slim(learned.theta);
    out[error] = learned.error;
    out[P] = slim(learned.P);
  }
  void update(Now now, Next next) const override {
    const Learned learned = learn(now);
    next[estimate] = learned.theta;
    next[covariance] = learned.P;
  }

 private:
  struct Learned {
    Array theta, P;
    Value error;
  };

  static Array slim(const Array& a) { return a.size() == 1 ? a.spread(Shape::scalar()) : a; }

  Learned learn(Now now) const {
    const int n = now[phi].size();
    const Array before = now[covariance], row = now[phi].spread(Shape::vector(n));
    const Array P_phi = mul(before, row);
    const Value miss = now[y][0] - dot(row, now[estimate]);
    const Array gain = P_phi / (now[forgetting][0] + dot(row, P_phi));
    Array kept(Shape::matrix(n, n));
    Value trace = 0;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j <= i; ++j) kept(i, j) = kept(j, i) = before(i, j) - gain[i] * P_phi[j];
      trace = trace + kept(i, i);
    }
    Array forgotten = kept / now[forgetting];
    if (now.given(max_trace)) forgotten = where(trace > now[max_trace][0] * now[forgetting][0], kept, forgotten);
    const Truth learns = abs(miss) >= now[dead_zone][0];
    return {where(learns, now[estimate] + gain * miss, now[estimate]), where(learns, forgotten, before), miss};
  }
};

}  // namespace

PLANTLOOP_BLOCK(recursive_least_squares, RecursiveLeastSquares)

}  // namespace plantloop
