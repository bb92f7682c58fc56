// Butterworth filters for samples.
//
// By the bilinear transform s = (z - 1)/(z + 1) with prewarped frequencies tan(w T/2): the gain at the cut-offs is
// exact. The lowpass variable p of a section is N/D: p = (z - 1)/(K (z + 1)), or for a band p = ((z - 1)^2 + w0^2 (z +
// 1)^2)/(B (z - 1)(z + 1)).

#include <fmt/format.h>
#include <vector>

#include "engine/block.h"
#include "engine/block_algebra.h"
#include "engine/block_design.h"

namespace plantloop {
namespace {

struct DiscreteButterworth final : Block {
  static constexpr auto summary = "Filter the samples of the input by a Butterworth filter.";
  static constexpr auto details =
      "The gain of a lowpass is 1/sqrt(1 + (tan(w T/2)/tan(frequency T/2))^(2 order)) with the period T: 1/sqrt(2) at "
      "the cut-off, 0 at half the sampling frequency. kind highpass is its mirror image; bandpass and bandstop have "
      "the cut-offs lower and upper and twice as many poles. Cut-offs lie below half the sampling frequency, pi/T. The "
      "sections stand one after the other.";
  static constexpr auto example = R"(
blocks:
  u: {type: sine, frequency: 10}
  y: {type: discrete_butterworth, in: u, order: 3, frequency: 10, rate: 0.01}
simulation: {stop: 5}
expect: [{signal: y, measure: max, from: 3, value: 1/sqrt(2), abs: 2e-3}]
)";

  Input u{this, "u", {.doc = "signal to filter"}};
  Butterworth design{this};
  Number initial_value{this,
                       "initial",
                       {.doc = "input before the start, to which the filter has settled; default: 0; may read signals",
                        .optional = true,
                        .initial = true}};
  Discrete x{this, "x", {.doc = "states of the sections", .size = any_size}};
  Output y{this, "y", {.doc = "the filtered signal"}};

  void check(Checking& checking) const override { design.check(checking); }
  void sizes(Sizing& sizing) const override {
    const Shape one = sizing.of(y);
    if (!one.is_known()) return;
    const int n = design.poles();
    sizing.set(x, one.size() == 1 ? Shape::vector(n) : Shape::matrix(n, one.size()));
  }
  void initial(Now now, Init init) const override {
    if (!now.given(initial_value)) return;
    Array signal = spread(now, now[initial_value]), start(now[x].shape());
    int at = 0;
    for (const TransferFunction& section : sections(now)) {
      const Array out = section.gain_at_rest(true) * signal;
      put(start, at, section.at_rest(out, signal, true));
      signal = out;
    }
    init[x] = start;
  }
  void outputs(Now now, Out out) const override {
    const Value highest = design.is_band() ? now[design.upper][0] : now[design.frequency][0];
    insist(now, (highest * now.period() < pi).value(),
           fmt::format("the cut-off of block '{}' is {{0:g}} rad/s, but it must lie below half the sampling frequency, "
                       "{{1:g}} rad/s",
                       now.path()),
           {highest, pi / now.period()});
    Array unused(now[x].shape());
    out[y] = through(now, unused);
  }
  void update(Now now, Next next) const override {
    Array after(now[x].shape());
    through(now, after);
    next[x] = after;
  }

 private:
  static constexpr double pi = 3.14159265358979323846;

  static int width(const Array& rows) { return rows.shape().rank == 2 ? rows.columns() : 1; }
  Array spread(Now now, const Array& signal) const { return TransferFunction::as_wide_as(now[x], signal); }
  // Rows `at` and the following ones of the states.
  static Array take(const Array& all, int at, int rows) {
    const int n = width(all);
    Array part(n == 1 ? Shape::vector(rows) : Shape::matrix(rows, n));
    for (int i = 0; i < part.size(); ++i) part[i] = all[at * n + i];
    return part;
  }
  static void put(Array& all, int& at, const Array& part) {
    for (int i = 0; i < part.size(); ++i) all[at * width(all) + i] = part[i];
    at += part.size() / width(all);
  }

  Array through(Now now, Array& after) const {
    Array signal = spread(now, now[u]);
    const Array x_now = now[x];
    int at = 0;
    for (const TransferFunction& section : sections(now)) {
      const Array part = take(x_now, at, section.order());
      const Array out = section.output(part, signal);
      put(after, at, section.change(part, signal));
      signal = out;
    }
    return signal;
  }

  std::vector<TransferFunction> sections(Now now) const {
    const auto vector = [](std::vector<Value> v) { return Array::vector(std::move(v)); };
    const auto warped = [&](Value w) { return tan(0.5 * w * now.period()); };
    Array N, D;
    if (design.is_band()) {
      const Value low = warped(now[design.lower][0]), high = warped(now[design.upper][0]);
      const Value square = low * high, band = high - low;
      N = vector({1.0 + square, 2.0 * square - 2.0, 1.0 + square});
      D = vector({band, 0.0, -band});
    } else {
      const Value K = warped(now[design.frequency][0]);
      N = vector({1.0, -1.0});
      D = vector({K, K});
    }
    std::vector<TransferFunction> list;
    for (const double damping : design.sections()) {
      if (damping == Butterworth::first_order) {
        list.emplace_back(design.passes_high() ? N : D, N + D);
        continue;
      }
      const Array NN = product(N, N), DD = product(D, D);
      list.emplace_back(design.passes_high() ? NN : DD, NN + damping * product(N, D) + DD);
    }
    return list;
  }

  static Array product(const Array& a, const Array& b) {
    Array c(Shape::vector(a.size() + b.size() - 1));
    for (int i = 0; i < a.size(); ++i) {
      for (int j = 0; j < b.size(); ++j) c[i + j] = c[i + j] + a[i] * b[j];
    }
    return c;
  }
};

}  // namespace

PLANTLOOP_BLOCK(discrete_butterworth, DiscreteButterworth)

}  // namespace plantloop
