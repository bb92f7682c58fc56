// The history of a delayed signal, and where it is not smooth.
//
// It holds the input at the ends of accepted steps and at the points inside them that make the solver's dense output a
// polynomial; each step is read by its own. Where something happens there are two samples of one time, the left one
// first. A break is such a pair at which a low derivative of the input may jump: its value (order 0), its slope (1),
// and so on. A break comes out one delay later; what it moves is one order smoother for each integration that it
// passes, so the method of steps stays as accurate as the solver is on smooth equations. Until a break comes out, every
// value belongs to the part before it, so that no step looks across.

#include "engine/block_delay.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "engine/program/kernel.h"
#include "engine/program/record.h"

namespace plantloop {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t most_nodes = 16;  // of a polynomial

// evaluate: the delay, the value before the start, and u where the present is read. advance: u, the delay, the value
// before the start, the bounds of the delay.
// The first history holds samples; the second the breaks: time, index of the right sample, order. The state is the
// number of breaks that have come out.
class PastSignal final : public Kernel {
 public:
  PastSignal(bool starts_with_input, bool varies, bool reads_present)
      : starts_with_input_(starts_with_input), varies_(varies), reads_present_(reads_present) {}
  std::string name() const override { return "dead time"; }
  // Of a delay that varies also: when is read less when the next break comes out, and the last one; they cross zero.
  int outputs() const override { return varies_ ? 3 : 1; }
  int state_size() const override { return 1; }
  int histories() const override { return 2; }
  double longest_step(const double* in) const override { return reads_present_ ? infinity : in[3]; }
  bool starts_with_inputs() const override { return starts_with_input_; }

  void initialise(const KernelCall& call) const override {
    call.state[0] = 0;
    for (int k = 0; k < 2; ++k) {
      History& history = call.history[k];
      history.time.clear(), history.value.clear(), history.order.clear();
    }
    if (starts_with_input_) append(call.history[0], call.time, call.in[0], History::end_of_step);
  }

  void evaluate(const KernelCall& call) const override {
    const History &samples = call.history[0], &breaks = call.history[1];
    if (varies_) call.out[1] = -1, call.out[2] = 1;
    if (samples.time.empty()) {
      call.out[0] = call.in[1];
      return;
    }
    const double at = call.time - call.in[0];
    const std::size_t part = call.left ? static_cast<std::size_t>(call.state[0]) : passed(call, call.in[0]);
    call.out[0] = value_in(part, at, call);
    if (!varies_) return;
    if (part < breaks.time.size()) call.out[1] = at - breaks.time[part];
    // At the break itself the later part is read: that counts as beyond.
    if (part > 0)
      call.out[2] = at == breaks.time[part - 1] ? std::numeric_limits<double>::min() : at - breaks.time[part - 1];
  }

  void advance(const KernelCall& call) const override {
    History& samples = call.history[0];
    const double u = call.in[0];
    if (samples.time.empty()) append(samples, call.time, starts_with_input_ ? u : call.in[2], History::end_of_step);
    if (!is_same_instant(samples.time.back(), call.time)) {
      // After a time in which nothing went on, in a subsystem that was not active, the last value has held until now.
      const double held = call.left ? u : samples.value.back();
      append(samples, call.time, held, call.inside ? History::inside_step : History::end_of_step);
    } else if (call.left && !call.inside && samples.order.back() == History::inside_step) {
      samples.order.back() = History::end_of_step;
    }
    if (call.left) return;
    append_right(call, u);
    call.state[0] = static_cast<double>(passed(call, call.in[1]));
    forget(call);
  }

  Break next_break(const KernelCall& call) const override {
    const History& breaks = call.history[1];
    const auto part = static_cast<std::size_t>(call.state[0]);
    const auto order = [&](std::size_t i) { return static_cast<int>(breaks.order[i]); };
    if (!varies_) return part < breaks.time.size() ? Break{breaks.time[part] + call.in[1], order(part)} : Break{};
    const double at = call.time - call.in[1];
    if (part < breaks.time.size() && at >= breaks.time[part]) return {call.time, order(part)};
    if (part > 0 && at < breaks.time[part - 1]) return {call.time, order(part - 1)};
    return {};
  }

 private:
  static void append(History& history, double time, double value, double order) {
    history.time.push_back(time);
    history.value.push_back(value);
    history.order.push_back(order);
  }

  // The right side of what stands at the end; several passes at one instant leave the last one.
  static void append_right(const KernelCall& call, double u) {
    History &samples = call.history[0], &breaks = call.history[1];
    const std::size_t n = samples.time.size();
    const bool is_pair = n > 1 && samples.time[n - 2] == samples.time[n - 1] && samples.order[n - 1] <= Break::smooth;
    double order = call.order;
    if (is_pair) {
      order = std::fmin(order, std::fmax(1, samples.order.back()));
      samples.value.back() = u;
    } else {
      append(samples, samples.time.back(), u, order);
    }
    const double left = samples.value[samples.value.size() - 2];
    if (std::fabs(u - left) > 1e-13 * std::fmax(std::fabs(u), std::fabs(left))) order = 0;
    samples.order.back() = order;
    const auto right = static_cast<double>(samples.time.size() - 1);
    const bool is_break = !breaks.value.empty() && breaks.value.back() == right;
    if (is_break) {
      breaks.order.back() = order;
    } else if (order < Break::smooth && !(order > 1 && is_crowded(call))) {
      append(breaks, samples.time.back(), right, order);
    }
  }

  // A delay that goes up and down fast brings each break out several times. Of so many that they lie this close, steps
  // end where the value or the slope jumps; the error control of the solver bears the others.
  static bool is_crowded(const KernelCall& call) {
    const History& breaks = call.history[1];
    const double near = std::fmax(1e-4 * call.in[1], 1e-7 * std::fmax(1, std::fabs(call.time)));
    return !breaks.time.empty() && call.time - breaks.time.back() < near;
  }

  // How many breaks have come out at the time of the call. A delay that varies is compared exactly, as the crossings of
  // evaluate() are.
  std::size_t passed(const KernelCall& call, double delay) const {
    const std::vector<double>& breaks = call.history[1].time;
    const auto first_ahead = std::partition_point(breaks.begin(), breaks.end(), [&](double t) {
      if (varies_) return t <= call.time - delay;
      return t + delay <= call.time || is_same_instant(t + delay, call.time);
    });
    return static_cast<std::size_t>(first_ahead - breaks.begin());
  }

  // The value at a time by the samples of one part: what lies before it or after it stands still.
  double value_in(std::size_t part, double at, const KernelCall& call) const {
    const History &samples = call.history[0], &breaks = call.history[1];
    const bool is_open = part == breaks.time.size();
    const std::size_t first = part == 0 ? 0 : static_cast<std::size_t>(breaks.value[part - 1]);
    const std::size_t last = is_open ? samples.time.size() - 1 : static_cast<std::size_t>(breaks.value[part]) - 1;
    if (at <= samples.time[first]) return samples.value[first];
    if (at >= samples.time[last]) {
      const bool between = is_open && reads_present_ && !is_same_instant(samples.time[last], call.time);
      return between                     ? with_present(samples, first, call, at)
             : is_open && reads_present_ ? call.in[2]
                                         : samples.value[last];
    }
    const auto from = samples.time.begin() + static_cast<std::ptrdiff_t>(first),
               to = samples.time.begin() + static_cast<std::ptrdiff_t>(last) + 1;
    std::size_t low = static_cast<std::size_t>(std::upper_bound(from, to, at) - samples.time.begin()) - 1;
    std::size_t high = low + 1;
    while (low > first && samples.order[low] == History::inside_step && high - low + 1 < most_nodes) --low;
    while (high < last && samples.order[high] == History::inside_step && high - low + 1 < most_nodes) ++high;
    return polynomial(samples.time.data() + low, samples.value.data() + low, high - low + 1, at);
  }

  // Between the last sample and now: a cubic through the last step and the present, or as much of it as there is.
  static double with_present(const History& samples, std::size_t first, const KernelCall& call, double at) {
    const std::size_t last = samples.time.size() - 1;
    std::size_t low = last;
    if (low > first && samples.time[low - 1] < samples.time[low]) {
      --low;
      while (low > first && samples.order[low] == History::inside_step) --low;
    }
    double time[4], value[4];
    std::size_t n = 0;
    for (const std::size_t i : {low, low + (last - low) / 2, last}) {
      if (n > 0 && samples.time[i] <= time[n - 1]) continue;
      time[n] = samples.time[i];
      value[n++] = samples.value[i];
    }
    time[n] = call.time;
    value[n++] = call.in[2];
    return polynomial(time, value, n, at);
  }

  // Neville's scheme.
  static double polynomial(const double* time, const double* value, std::size_t n, double at) {
    double p[most_nodes] = {};
    std::copy_n(value, n, p);
    for (std::size_t degree = 1; degree < n; ++degree) {
      for (std::size_t k = 0; k + degree < n; ++k) {
        const double left = time[k], right = time[k + degree];
        p[k] = ((right - at) * p[k] + (at - left) * p[k + 1]) / (right - left);
      }
    }
    return p[0];
  }

  // Drops what is older than the longest delay, now and then.
  static void forget(const KernelCall& call) {
    History &samples = call.history[0], &breaks = call.history[1];
    const double oldest = call.time - call.in[4];
    const auto needed = std::upper_bound(samples.time.begin(), samples.time.end(), oldest) - samples.time.begin();
    const auto count = needed - static_cast<std::ptrdiff_t>(2 * most_nodes);
    if (count < 64 || 2 * count < static_cast<std::ptrdiff_t>(samples.time.size())) return;
    const auto drop = [](std::vector<double>& list, std::ptrdiff_t n) { list.erase(list.begin(), list.begin() + n); };
    drop(samples.time, count), drop(samples.value, count), drop(samples.order, count);
    const auto gone =
        std::lower_bound(breaks.value.begin(), breaks.value.end(), static_cast<double>(count)) - breaks.value.begin();
    drop(breaks.time, gone), drop(breaks.value, gone), drop(breaks.order, gone);
    for (double& index : breaks.value) index -= static_cast<double>(count);
    call.state[0] = std::fmax(0.0, call.state[0] - static_cast<double>(gone));
  }

  bool starts_with_input_, varies_, reads_present_;
};

}  // namespace

Value delayed(Now now, Value u, const DeadTime& time) {
  const bool varies = time.shortest.has_value();
  const Value past = time.past.value_or(Value(0.0));
  std::vector<Value> read{time.delay, past};
  if (time.reads_present) read.push_back(u);
  const std::vector<Value> kept{u, time.delay, past, time.shortest.value_or(time.delay),
                                time.longest.value_or(time.delay)};
  const std::vector<Value> out =
      now.kernel(std::make_shared<PastSignal>(!time.past, varies, time.reads_present), std::move(read), kept);
  if (varies) {
    Crossing into = crossing(Array(out[1]), Direction::rising), back = crossing(Array(out[2]), Direction::falling);
    into.of_kernel = back.of_kernel = true;
    Jumps().when(into);
    Jumps().when(back);
  }
  return out[0];
}

Array delayed_loop(Now now, const Shape& shape, const DeadTime& time, const std::function<Array(const Array&)>& next) {
  Recorder& recorder = *Recorder::current();
  Array coming(shape), late(shape);
  for (int i = 0; i < shape.size(); ++i) {
    coming[i] = recorder.wire();
    late[i] = delayed(now, coming[i], time);
  }
  const Array driver = next(late);
  for (int i = 0; i < shape.size(); ++i) recorder.bind(coming[i], driver.at(i));
  return late;
}

}  // namespace plantloop
