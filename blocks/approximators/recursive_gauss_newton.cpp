// A network that learns while the plant runs.
//
// Recursive Gauss-Newton method: L. Ljung and T. Soderstrom, Theory and Practice of Recursive Identification, 1983; as
// an extended Kalman filter for the weights: S. Singhal and L. Wu, Training multilayer perceptrons with the extended
// Kalman algorithm, 1989. Safeguards: K. Astrom and B. Wittenmark, Adaptive Control, 2nd edition 1995, section 11.5.

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "engine/block.h"
#include "engine/block_algebra.h"
#include "engine/block_random.h"

namespace plantloop {
namespace {

// The lower triangle of a symmetric matrix, row by row.
int packed(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }

struct RecursiveGaussNewton final : Block {
  static constexpr auto summary =
      "Learn the weights of a network from sample to sample, by the recursive Gauss-Newton method.";
  static constexpr auto details =
      "Of y[k] = f(x[k], w) + v[k] with psi = df/dw:  error = y - f,  s = psi' P psi,  K = P psi/(forgetting + s),  w+ "
      "= "
      "w + K error,  P+ = (P - K psi' P)/forgetting: recursive least squares along the tangent of the network. network "
      "mlp: f = b + sum_j a_j tanh(c_j' x + d_j) over `hidden` neurons, w = (a, b, then c_j, d_j of each neuron); "
      "learned "
      "all: all of them; output: a and b only. network rbf: f = b + sum_j a_j exp(-|x - centre_j|^2/(2 width_j^2)), w "
      "= "
      "(a, b); as with the output weights of an mlp the network is then linear in what is learned, and the result is "
      "that of least squares over all samples.  Safeguards: errors within the dead_zone teach nothing; a sample with s "
      "below min_information, of which the network is sure already, neither teaches nor makes anything forgotten; "
      "nothing is forgotten while the trace of P would exceed max_trace; when it falls below min_trace, what is "
      "missing is added to the diagonal, so that the network never falls asleep; lower and upper limit each weight.  "
      "`ahead` is the network at x_ahead, for a prediction from the present sample.";
  static constexpr auto example = R"(
title: Five radial functions learn a parabola while it is shown to them
blocks:
  u: {type: random_levels, lower: -1, upper: 1, rate: 0.1}
  net:
    type: recursive_gauss_newton
    network: rbf
    in: {y: u^2, x: u, x_ahead: 0.5}
    centres: [-1, -0.5, 0, 0.5, 1]
    widths: 0.5
simulation: {stop: 30}
expect:
  - {signal: net.ahead, measure: final, value: 0.25, abs: 0.01}
  - {signal: net.error, from: 20, max_abs: 0.05}
)";

  Input y{this, "y", {.doc = "what the network should give", .size = scalar}};
  Input x{this, "x", {.doc = "inputs of the network", .size = any_size}};
  Input x_ahead{this, "x_ahead", {.doc = "other inputs, of which `ahead` is the answer", .init = 0, .size = any_size}};
  Choice network{this, "network", {.of = {"mlp", "rbf"}, .doc = "neurons, or radial functions"}};
  Choice learned{this, "learned", {.of = {"all", "output"}, .doc = "of an mlp: all weights, or those of the output"}};
  Count hidden{this, "hidden", {.init = 5, .doc = "neurons of an mlp", .min = 1, .max = 100}};
  Table centres{
      this, "centres", {.doc = "of an rbf: a row for each function; a vector where x is a scalar", .optional = true}};
  Table widths{this, "widths", {.init = "1", .doc = "of an rbf: one for all, or one for each function", .above = 0}};
  Table initial_value{this,
                      "initial",
                      {.doc = "weights at the start, all of them; may read signals; default: a, b = 0, c and d random",
                       .optional = true,
                       .initial = true}};
  Number spread{
      this,
      "spread",
      {.init = 1, .doc = "of the random weights at the start: even in -spread to spread", .min = 0, .size = scalar}};
  Number seed{
      this,
      "seed",
      {.init = 1, .doc = "another whole number, other weights", .min = 0, .max = 9007199254740992, .size = scalar}};
  Number P0{this,
            "P",
            {.init = 100,
             .doc = "variance of each weight's error at the start, over that of the noise",
             .above = 0,
             .size = scalar}};
  Number forgetting{this,
                    "forgetting",
                    {.init = 1,
                     .doc = "what the weight of a sample is multiplied by at the next",
                     .max = 1,
                     .above = 0,
                     .size = scalar}};
  Number dead_zone{
      this, "dead_zone", {.init = 0, .doc = "errors up to this one teach nothing", .min = 0, .size = scalar}};
  Number min_information{
      this, "min_information", {.init = 0, .doc = "samples with s below it are left out", .min = 0, .size = scalar}};
  Number max_trace{
      this,
      "max_trace",
      {.doc = "greatest sum of the variances in P; default: no limit", .above = 0, .size = scalar, .optional = true}};
  Number min_trace{
      this,
      "min_trace",
      {.doc = "least sum of the variances in P; default: no limit", .above = 0, .size = scalar, .optional = true}};
  Limits limits{this, "least value of a weight", "greatest value of a weight"};
  Discrete weights{this, "weights", {.doc = "the weights", .size = any_size}};
  Discrete covariance{this, "covariance", {.doc = "the lower triangle of P, row by row", .size = any_size}};
  Output fitted{this, "fitted", {.doc = "f(x, w)"}};
  Output error{this, "error", {.doc = "y - f(x, w)"}};
  Output ahead{this, "ahead", {.doc = "f(x_ahead, w)"}};
  Output w{this, "w", {.doc = "the weights, before the present sample", .size = any_size}};
  Output trace{this, "trace", {.doc = "of P, before the present sample"}};

  void sizes(Sizing& sizing) const override {
    const Shape regressors = sizing.of(x);
    if (!regressors.is_known()) return;
    const int n = regressors.size();
    int count = 0;
    if (network.is("rbf")) {
      const Shape shape = sizing.of(centres);
      if (!shape.is_known()) return;
      count = n == 1 ? shape.size() : shape.rows;
      if (n > 1 && (shape.rank != 2 || shape.columns != n))
        sizing.problem(centres,
                       fmt::format("centres must have a row of {} numbers for each function, as x has, but it is {}", n,
                                   to_string(shape)));
      const Shape width = sizing.of(widths);
      if (width.is_known() && width.size() != 1 && width.size() != count)
        sizing.problem(widths,
                       fmt::format("widths must be one number or one for each of the {} functions, but it is {}", count,
                                   to_string(width)));
    } else {
      count = hidden.value();
    }
    const int all = count + 1 + (network.is("mlp") ? count * (n + 1) : 0);
    const int taught = learns_all() ? all : count + 1;
    if (taught > most_weights)
      sizing.problem(hidden, fmt::format("{} weights are learned at once, at most {} can be", taught, most_weights));
    sizing.expect(x_ahead, n == 1 ? Shape::scalar() : Shape::vector(n));
    sizing.set(weights, Shape::vector(all));
    sizing.set(w, Shape::vector(all));
    sizing.set(covariance, Shape::vector(taught * (taught + 1) / 2));
    const Shape start = sizing.of(initial_value);
    if (start.is_known() && start.size() != all)
      sizing.problem(initial_value, fmt::format("initial must have {} elements, one for each weight, but it is {}", all,
                                                to_string(start)));
  }

  void check(Checking& checking) const override {
    limits.check(checking);
    check_seed(checking, seed);
    if (network.is("rbf") && !checking.given(centres))
      checking.problem(centres, "network rbf needs 'centres', a row of numbers for each function");
    if (network.is("mlp") && checking.given(centres)) checking.problem(centres, "network mlp has no centres");
    const auto least = checking.of(min_trace), most = checking.of(max_trace);
    if (!least.empty() && !most.empty() && least[0] > most[0])
      checking.problem(min_trace, "it must not be greater than 'max_trace'");
  }

  void initial(Now now, Init init) const override {
    const int count = functions(now), taught = taught_weights(now);
    Array start(Shape::vector(all_weights(now)));
    if (now.given(initial_value)) {
      start = now[initial_value].spread(start.shape());
    } else if (network.is("mlp")) {
      const auto drawn = random_numbers(now, Distribution::uniform, now[seed][0], 0, start.size());
      for (int i = count + 1; i < start.size(); ++i)
        start[i] = now[spread][0] * (2.0 * drawn[static_cast<std::size_t>(i)] - 1.0);
    }
    init[weights] = limits.clamp(now, start);
    Array P(Shape::vector(taught * (taught + 1) / 2));
    for (int i = 0; i < taught; ++i) P[packed(i, i)] = now[P0][0];
    init[covariance] = P;
  }

  void outputs(Now now, Out out) const override {
    const Value fit = answer(now, row(now[x]));
    out[fitted] = fit;
    out[error] = now[y][0] - fit;
    out[ahead] = answer(now, row(now[x_ahead].spread(now[x].shape())));
    out[w] = now[weights];
    out[trace] = trace_of(now[covariance], taught_weights(now));
  }

  void update(Now now, Next next) const override {
    const int n = taught_weights(now);
    const Array before = now[covariance], psi = gradient(now, row(now[x]));
    Array P_psi(Shape::vector(n));
    for (int i = 0; i < n; ++i) {
      Array line(Shape::vector(n));
      for (int j = 0; j < n; ++j) line[j] = before[packed(i, j)];
      P_psi[i] = dot(line, psi);
    }
    const Value miss = now[y][0] - answer(now, row(now[x])), information = dot(psi, P_psi);
    const Array gain = P_psi / (now[forgetting][0] + information);

    Array kept(before.shape());
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j <= i; ++j) kept[packed(i, j)] = before[packed(i, j)] - gain[i] * P_psi[j];
    }
    const Value remaining = trace_of(kept, n);
    Array forgotten = kept / now[forgetting];
    if (now.given(max_trace)) forgotten = where(remaining > now[max_trace][0] * now[forgetting][0], kept, forgotten);
    if (now.given(min_trace)) {
      const Value missing = max(now[min_trace][0] - trace_of(forgotten, n), Value(0.0)) / static_cast<double>(n);
      for (int i = 0; i < n; ++i) forgotten[packed(i, i)] = forgotten[packed(i, i)] + missing;
    }
    const Truth learns = abs(miss) >= now[dead_zone][0] && information >= now[min_information][0];
    Array moved = now[weights];
    for (int i = 0; i < n; ++i) moved[i] = moved[i] + gain[i] * miss;
    next[weights] = where(learns, limits.clamp(now, moved), now[weights]);
    next[covariance] = where(learns, forgotten, before);
  }

 private:
  // The covariance has half the square of it.
  static constexpr int most_weights = 200;

  bool learns_all() const { return network.is("mlp") && learned.is("all"); }
  static Array row(const Array& a) { return a.spread(Shape::vector(a.size())); }
  int functions(Now now) const {
    if (network.is("mlp")) return hidden.value();
    return now[x].size() == 1 ? now[centres].size() : now[centres].rows();
  }
  int all_weights(Now now) const {
    const int count = functions(now);
    return count + 1 + (network.is("mlp") ? count * (now[x].size() + 1) : 0);
  }
  int taught_weights(Now now) const { return learns_all() ? all_weights(now) : functions(now) + 1; }
  static Value trace_of(const Array& P, int n) {
    Array diagonal(Shape::vector(n));
    for (int i = 0; i < n; ++i) diagonal[i] = P[packed(i, i)];
    return sum(diagonal);
  }

  // The outputs of the neurons or radial functions, and 1.
  Array hidden_outputs(Now now, const Array& in) const {
    const int n = in.size(), count = functions(now);
    Array h(Shape::vector(count + 1), 1);
    for (int j = 0; j < count; ++j) {
      if (network.is("mlp")) {
        Array c(Shape::vector(n));
        for (int i = 0; i < n; ++i) c[i] = now[weights][first_of(now, j) + i];
        h[j] = tanh(dot(c, in) + now[weights][first_of(now, j) + n]);
      } else {
        Array off(Shape::vector(n));
        for (int i = 0; i < n; ++i) off[i] = in[i] - now[centres][j * n + i];
        const Value width = now[widths].size() == 1 ? now[widths][0] : now[widths][j];
        h[j] = exp(dot(off, off) / (-2.0 * (width * width)));
      }
    }
    return h;
  }
  // Where the weights of a neuron begin.
  int first_of(Now now, int neuron) const { return functions(now) + 1 + neuron * (now[x].size() + 1); }
  Array output_weights(Now now) const {
    Array a(Shape::vector(functions(now) + 1));
    for (int j = 0; j < a.size(); ++j) a[j] = now[weights][j];
    return a;
  }
  Value answer(Now now, const Array& in) const { return dot(output_weights(now), hidden_outputs(now, in)); }
  // df/dw of the weights that are learned.
  Array gradient(Now now, const Array& in) const {
    const Array h = hidden_outputs(now, in);
    if (!learns_all()) return h;
    const int n = in.size(), count = functions(now);
    Array psi(Shape::vector(all_weights(now)));
    for (int j = 0; j <= count; ++j) psi[j] = h[j];
    for (int j = 0; j < count; ++j) {
      const Value slope = now[weights][j] * (1.0 - h[j] * h[j]);
      for (int i = 0; i < n; ++i) psi[first_of(now, j) + i] = slope * in[i];
      psi[first_of(now, j) + n] = slope;
    }
    return psi;
  }
};

}  // namespace

PLANTLOOP_BLOCK(recursive_gauss_newton, RecursiveGaussNewton)

}  // namespace plantloop
