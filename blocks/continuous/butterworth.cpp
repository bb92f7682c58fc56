// Butterworth filters, of second-order sections of integrators.
//
// The lowpass of cut-off 1 with n poles has the sections 1/(p^2 + 2 sin((2i-1) pi/(2n)) p + 1), i = 1 ... n/2, and, for
// odd n, 1/(p + 1). Each is built of integrators 1/p: h = in - x1 - 2 zeta x2, x2 = h/p, x1 = x2/p; x1 is its lowpass,
// h its highpass. With 1/p = w/s they have the cut-off w; with the resonator 1/p = B s/(s^2 + w0^2) the lowpass becomes
// a bandpass and the highpass a bandstop (L. Weinberg, Network Analysis and Synthesis, 11).

#include <cstddef>
#include <vector>

#include "engine/block.h"
#include "engine/block_algebra.h"
#include "engine/block_design.h"

namespace plantloop {
namespace {

struct ButterworthFilter final : Block {
  static constexpr auto summary = "Filter the input by a Butterworth filter.";
  static constexpr auto details =
      "The gain of a lowpass is 1/sqrt(1 + (w/frequency)^(2 order)): flat, 1/sqrt(2) at the cut-off, falling by 20 "
      "order dB per decade. kind highpass is its mirror image; bandpass and bandstop have the cut-offs lower and upper "
      "and twice as many poles. The sections stand one after the other.";
  static constexpr auto example = R"(
blocks:
  u: {type: sine, frequency: 10}
  y: {type: butterworth, in: u, order: 3, frequency: 10}
simulation: {stop: 5}
expect: [{signal: y, measure: max, from: 3, value: 1/sqrt(2), abs: 1e-3}]
)";

  Input u{this, "u", {.doc = "signal to filter"}};
  Butterworth design{this};
  Number initial_value{this,
                       "initial",
                       {.doc = "input before the start, to which the filter has settled; default: 0; may read signals",
                        .optional = true,
                        .initial = true}};
  State x{this, "x", {.doc = "states of the sections", .size = any_size}};
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
    Array start(now[x].shape());
    for (int e = 0; e < width(now); ++e) settle(now, now[initial_value].at(e), e, start);
    init[x] = start;
  }
  void outputs(Now now, Out out) const override {
    Array filtered(width(now) == 1 ? Shape::scalar() : Shape::vector(width(now)));
    Array unused(now[x].shape());
    for (int e = 0; e < width(now); ++e) filtered[e] = through(now, e, unused);
    out[y] = filtered;
  }
  void derivatives(Now now, Rates rate) const override {
    Array change(now[x].shape());
    for (int e = 0; e < width(now); ++e) through(now, e, change);
    rate[x] = change;
  }

 private:
  static int width_of(const Array& x) { return x.shape().rank == 2 ? x.columns() : 1; }
  int width(Now now) const { return width_of(now[x]); }

  // What element e of the input gives, and the derivatives of the states on its way.
  Value through(Now now, int e, Array& change) const {
    const Array x_now = now[x];
    const int step = width(now);
    int at = e;
    // The present output of the next integrator, and its derivative once its input is known.
    const auto integral = [&](int place) { return x_now[place]; };
    const auto feed = [&](int place, Value in) {
      if (!design.is_band()) {
        change[place] = design.cut_off(now) * in;
        return;
      }
      change[place] = design.band(now) * in - design.centre(now) * x_now[place + step];
      change[place + step] = design.centre(now) * x_now[place];
    };
    const int size = design.is_band() ? 2 * step : step;  // of an integrator
    Value signal = now[u].at(e);
    for (const double damping : design.sections()) {
      if (damping == Butterworth::first_order) {
        const Value low = integral(at), high = signal - low;
        feed(at, high);
        signal = design.passes_high() ? high : low;
        at += size;
        continue;
      }
      const int first = at, second = at + size;
      const Value high = signal - integral(second) - damping * integral(first);
      feed(first, high);
      feed(second, integral(first));
      signal = design.passes_high() ? high : integral(second);
      at += 2 * size;
    }
    return signal;
  }

  // The states after a constant input: integrators have no input, resonators give none.
  void settle(Now now, Value in, int e, Array& start) const {
    const int step = width_of(start), size = design.is_band() ? 2 * step : step;
    int at = e;
    for (const double damping : design.sections()) {
      const bool first_order = damping == Butterworth::first_order;
      if (design.is_band()) {
        start[at + step] = design.band(now) * in / design.centre(now);
      } else {
        start[first_order ? at : at + size] = in;
      }
      if (design.is_band() != design.passes_high()) in = 0;
      at += first_order ? size : 2 * size;
    }
  }
};

}  // namespace

PLANTLOOP_BLOCK(butterworth, ButterworthFilter)

}  // namespace plantloop
