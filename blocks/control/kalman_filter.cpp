// The Kalman filter of a sampled linear system.
//
// R. Kalman, A new approach to linear filtering and prediction problems, 1960; the covariance in the form of P. Joseph,
// which stays symmetric and positive.

#include <fmt/format.h>

#include "engine/block.h"
#include "engine/block_algebra.h"

namespace plantloop {
namespace {

struct KalmanFilter final : Block {
  static constexpr auto summary = "Estimate the states of a sampled linear system from noisy measurements.";
  static constexpr auto details =
      "Of x[k+1] = A x[k] + B u[k] + w,  y[k] = C x[k] + D u[k] + v, w and v white with covariances Q and R.  At each "
      "sample, with the predicted x- and its covariance P-:  S = C P- C' + R,  K = P- C' S^-1,  x = x- + K (y - C x- - "
      "D u),  P = (I - K C) P- (I - K C)' + K R K',  then x- becomes A x + B u and P- becomes A P A' + Q.  estimate "
      "current: the output is x, with the present measurement; predicted: it is x-, without it.  Q, R and P are "
      "matrices, vectors of diagonals, or one number for the whole diagonal.  B may be a vector where there is one "
      "input, C where there is one measurement.";
  static constexpr auto example = R"(
title: A constant of 5 in noise of deviation 1
blocks:
  noise: {type: white_noise, rate: 0.1}
  level: {type: kalman_filter, in: {y: 5 + noise}, A: 1, C: 1, Q: 0, R: 1, P: 1e6}
simulation: {stop: 1000}
expect: [{signal: level.x, measure: final, value: 5, abs: 0.05}]
)";

  Input y{this, "y", {.doc = "the measurements", .size = any_size}};
  Input u{this, "u", {.doc = "known inputs of the system", .init = 0, .size = any_size}};
  Table A{this, "A", {.doc = "n by n", .zeros_matter = true}};
  Table B{this, "B", {.doc = "n by the number of inputs; default: 0", .zeros_matter = true, .optional = true}};
  Table C{this, "C", {.doc = "the number of measurements by n", .zeros_matter = true}};
  Table D{this,
          "D",
          {.doc = "the number of measurements by that of inputs; default: 0", .zeros_matter = true, .optional = true}};
  Table Q{this, "Q", {.init = "1", .doc = "covariance of the noise that drives the states"}};
  Table R{this, "R", {.init = "1", .doc = "covariance of the noise of the measurements"}};
  Table P0{this, "P", {.init = "1", .doc = "covariance of the error of `initial`"}};
  Table initial_value{this,
                      "initial",
                      {.init = "0",
                       .doc = "predicted states at the start, n numbers or one for all; may read signals",
                       .initial = true}};
  Choice estimate{
      this, "estimate", {.of = {"current", "predicted"}, .doc = "whether the output knows the present measurement"}};
  Discrete predicted{this, "predicted", {.doc = "predicted states", .size = any_size}};
  Discrete covariance{this, "covariance", {.doc = "covariance of their error", .size = any_size}};
  Output x{this, "x", {.doc = "estimated states", .size = any_size}};
  Output fitted{this, "fitted", {.doc = "C x + D u", .size = any_size}};

  void sizes(Sizing& sizing) const override {
    const Shape a = sizing.of(A), c = sizing.of(C);
    if (!a.is_known() || !c.is_known()) return;
    if (a.rows != a.columns) return sizing.problem(A, fmt::format("A must be square, but it is {}", to_string(a)));
    const int n = a.rows, p = c.size() / n;
    const int columns = c.rank == 2 ? c.columns : n == 1 ? 1 : c.rows;
    if (columns != n) return sizing.problem(C, fmt::format("C has {} columns, A has {} rows", columns, n));
    sizing.set(predicted, Shape::vector(n));
    sizing.set(covariance, Shape::matrix(n, n));
    sizing.set(x, one_or_many(n));
    sizing.set(fitted, one_or_many(p));
    sizing.expect(y, one_or_many(p));
    check_inputs(sizing, n, p);
    check_covariance(sizing, Q, n), check_covariance(sizing, R, p), check_covariance(sizing, P0, n);
    const Shape start = sizing.of(initial_value);
    if (!start.is_known() || start.size() == 1 || start.size() == n) return;
    sizing.problem(initial_value,
                   fmt::format("initial must have {} elements, one for each state, but it is {}", n, to_string(start)));
  }

  void initial(Now now, Init init) const override {
    init[predicted] = now[initial_value];
    init[covariance] = full_covariance(now[P0], now[A].rows());
  }
  void outputs(Now now, Out out) const override {
    const Array known = estimate.is("current") ? correct(now).x : now[predicted];
    const Array fit = mul(output_matrix(now), known) + through(now, D, measurements(now));
    out[x] = known.size() == 1 ? known.spread(Shape::scalar()) : known;
    out[fitted] = fit.size() == 1 ? fit.spread(Shape::scalar()) : fit;
  }
  void update(Now now, Next next) const override {
    const Corrected known = correct(now);
    const int n = now[A].rows();
    const Array a = now[A].spread(Shape::matrix(n, n));
    next[predicted] = mul(a, known.x) + through(now, B, n);
    next[covariance] = mul(mul(a, known.P), transpose(a)) + full_covariance(now[Q], n);
  }

 private:
  struct Corrected {
    Array x, P;
  };

  static Shape one_or_many(int n) { return n == 1 ? Shape::scalar() : Shape::vector(n); }
  int measurements(Now now) const { return now[C].size() / now[A].rows(); }
  Array output_matrix(Now now) const { return now[C].spread(Shape::matrix(measurements(now), now[A].rows())); }

  void check_inputs(Sizing& sizing, int n, int p) const {
    const Shape b = sizing.of(B), d = sizing.of(D);
    const int by_b = b.is_known() ? b.size() / n : 0, by_d = d.is_known() ? d.size() / p : 0;
    if (b.is_known() && b.size() % n != 0)
      return sizing.problem(B, fmt::format("B is {}, A has {} rows", to_string(b), n));
    if (d.is_known() && d.size() % p != 0)
      return sizing.problem(D, fmt::format("D is {}, there are {} measurements", to_string(d), p));
    if (by_b > 0 && by_d > 0 && by_b != by_d) {
      return sizing.problem(D, fmt::format("D is for {} inputs, B for {}", by_d, by_b));
    }
    if (by_b + by_d > 0) sizing.expect(u, one_or_many(by_b > 0 ? by_b : by_d));
  }

  // What the known inputs give through B or D: as many rows as asked for.
  Array through(Now now, const Table& table, int rows) const {
    if (!now.given(table)) return Array(Shape::vector(rows));
    const int m = now[table].size() / rows;
    return mul(now[table].spread(Shape::matrix(rows, m)), now[u].spread(Shape::vector(m)));
  }

  Corrected correct(Now now) const {
    const int n = now[A].rows(), p = measurements(now);
    const Array c = output_matrix(now), before = now[covariance], noise = full_covariance(now[R], p);
    const Array cross = mul(c, before);  // C P-, transposed P- C'
    const Array gain = transpose(solve_symmetric(mul(cross, transpose(c)) + noise, cross));
    const Array innovation = now[y].spread(Shape::vector(p)) - mul(c, now[predicted]) - through(now, D, p);
    Array rest = -mul(gain, c);
    for (int i = 0; i < n; ++i) rest(i, i) = rest(i, i) + 1.0;
    return {now[predicted] + mul(gain, innovation),
            mul(mul(rest, before), transpose(rest)) + mul(mul(gain, noise), transpose(gain))};
  }
};

}  // namespace

PLANTLOOP_BLOCK(kalman_filter, KalmanFilter)

}  // namespace plantloop
