// A dead time.
//
// The history holds the input at the ends of accepted steps and at some points inside them. Where the input jumps there
// are two samples of one time, the left one first; where it may have a kink, two equal ones. Polynomials never reach
// across such a pair. Jumps come out one delay later: the solver stops there, and until then the value before the jump
// is given.

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "engine/block.h"
#include "engine/program/kernel.h"

namespace plantloop {
namespace {

// The state is the part of the history between two jumps that is given now: its first sample, and its last one, or -1
// while no further jump has happened.
class DeadTime final : public Kernel {
 public:
  explicit DeadTime(bool starts_with_input) : starts_with_input_(starts_with_input) {}
  std::string name() const override { return "dead time"; }
  int outputs() const override { return 1; }
  int state_size() const override { return 2; }
  int histories() const override { return 1; }
  double longest_step(const double* in) const override { return in[1]; }
  bool starts_with_inputs() const override { return starts_with_input_; }

  void initialise(const KernelCall& call) const override {
    call.state[0] = 0, call.state[1] = open;
    call.history->time.clear();
    call.history->value.clear();
    if (starts_with_input_) append(call, call.in[0]);
  }

  void evaluate(const KernelCall& call) const override {
    const std::vector<double>&time = call.history->time, &value = call.history->value;
    if (time.empty()) {
      call.out[0] = call.in[1];
      return;
    }
    const double at = call.time - call.in[0];
    const auto first = static_cast<std::size_t>(call.state[0]);
    const std::size_t last = call.state[1] == open ? time.size() - 1 : static_cast<std::size_t>(call.state[1]);
    if (at <= time[first]) {
      call.out[0] = value[first];
    } else if (at >= time[last]) {
      call.out[0] = value[last];
    } else {
      const auto from = time.begin() + static_cast<std::ptrdiff_t>(first),
                 to = time.begin() + static_cast<std::ptrdiff_t>(last) + 1;
      const auto after = static_cast<std::size_t>(std::upper_bound(from, to, at) - time.begin());
      call.out[0] = interpolate(*call.history, first, last, after - 1, at);
    }
  }

  void advance(const KernelCall& call) const override {
    std::vector<double>&time = call.history->time, &value = call.history->value;
    const double u = call.in[0];
    if (time.empty() && !starts_with_input_) append(call, call.in[2]);
    if (time.empty() || !is_same_instant(time.back(), call.time)) {
      append(call, u);
    } else if (!call.left) {
      // The right side of what stands there; several passes at one instant leave the last one.
      const bool is_pair = time.size() > 1 && time[time.size() - 2] == time.back();
      if (is_pair) {
        value.back() = u;
      } else {
        time.push_back(time.back());
        value.push_back(u);
      }
      if (call.state[1] == open && jumps_at(*call.history, time.size() - 2))
        call.state[1] = static_cast<double>(time.size() - 2);
    }
    if (call.left) return;
    while (call.state[1] != open && (next_jump(call) <= call.time || is_same_instant(next_jump(call), call.time)))
      go_on(call);
    forget(call);
  }

  double next_jump(const KernelCall& call) const override {
    if (call.state[1] == open) return std::numeric_limits<double>::infinity();
    return call.history->time[static_cast<std::size_t>(call.state[1])] + call.in[1];
  }

 private:
  static constexpr double open = -1;
  static constexpr std::size_t nodes = 6;

  static void append(const KernelCall& call, double u) {
    call.history->time.push_back(call.time);
    call.history->value.push_back(u);
  }

  // Samples i and i + 1 are the sides of a jump, not of a kink or of nothing at all.
  static bool jumps_at(const History& h, std::size_t i) {
    return h.time[i] == h.time[i + 1] &&
           std::fabs(h.value[i] - h.value[i + 1]) > 1e-13 * std::fmax(std::fabs(h.value[i]), std::fabs(h.value[i + 1]));
  }

  // The part after the next jump.
  static void go_on(const KernelCall& call) {
    const auto first = static_cast<std::size_t>(call.state[1]) + 1;
    call.state[0] = static_cast<double>(first);
    call.state[1] = open;
    for (std::size_t i = first; i + 1 < call.history->time.size(); ++i) {
      if (!jumps_at(*call.history, i)) continue;
      call.state[1] = static_cast<double>(i);
      return;
    }
  }

  // Drops what is older than the delay, now and then.
  static void forget(const KernelCall& call) {
    std::vector<double>&time = call.history->time, &value = call.history->value;
    const auto needed = std::upper_bound(time.begin(), time.end(), call.time - call.in[1]) - time.begin();
    const auto old = needed - static_cast<std::ptrdiff_t>(2 * nodes);
    if (old < 64 || 2 * old < static_cast<std::ptrdiff_t>(time.size())) return;
    const auto count = call.state[1] == open ? old : std::min(old, static_cast<std::ptrdiff_t>(call.state[1]));
    time.erase(time.begin(), time.begin() + count);
    value.erase(value.begin(), value.begin() + count);
    call.state[0] = std::fmax(0.0, call.state[0] - static_cast<double>(count));
    if (call.state[1] != open) call.state[1] -= static_cast<double>(count);
  }

  // The polynomial through the samples nearest to interval i, i + 1, none of them beyond a pair of equal times
  // (Neville's scheme).
  static double interpolate(const History& h, std::size_t first, std::size_t last, std::size_t i, double at) {
    std::size_t low = i, high = i + 1;
    while (high - low + 1 < nodes) {
      const bool down = low > first && h.time[low - 1] < h.time[low];
      const bool up = high < last && h.time[high + 1] > h.time[high];
      if (!down && !up) break;
      if (down && (!up || i - low <= high - i - 1)) {
        --low;
      } else {
        ++high;
      }
    }
    double p[nodes];
    const std::size_t n = high - low + 1;
    std::copy_n(h.value.begin() + static_cast<std::ptrdiff_t>(low), n, p);
    for (std::size_t degree = 1; degree < n; ++degree) {
      for (std::size_t k = 0; k + degree < n; ++k) {
        const double left = h.time[low + k], right = h.time[low + k + degree];
        p[k] = ((right - at) * p[k] + (at - left) * p[k + 1]) / (right - left);
      }
    }
    return p[0];
  }

  bool starts_with_input_;
};

struct TransportDelay final : Block {
  static constexpr auto summary = "Delay the input by a time.";
  static constexpr auto details =
      "y(t) = u(t - delay); before the start u was `initial`, by default its value at the start. Where the delay is 0, "
      "y = u. A loop "
      "through the block needs `initial`, since u at the start then depends on y. The solver takes no step longer than "
      "the delay, and "
      "stops where a jump of the input comes out.";
  static constexpr auto icon = "exp(-delay*s)";
  static constexpr auto example = R"(
blocks:
  u: {type: sine}
  late: {type: transport_delay, in: u, delay: 0.5}
simulation: {stop: 1}
expect: [{signal: late, at: 1, value: sin(0.5), abs: 1e-6}]
)";

  Input u{this, "u", {.doc = "signal to delay"}};
  Table delay{this,
              "delay",
              {.unit = "s",
               .doc = "the dead time; one for each element of a vector, or one for all",
               .zeros_matter = true,
               .min = 0}};
  Number initial_value{this,
                       "initial",
                       {.doc = "input before the start; default: the input at the start; may read signals",
                        .optional = true,
                        .initial = true}};
  Output y{this, "y", {.doc = "the delayed signal"}};

  RateKind rate_kind() const override { return RateKind::continuous; }

  void sizes(Sizing& sizing) const override {
    const Shape one = sizing.of(y), times = sizing.of(delay);
    if (!one.is_known() || !times.is_known() || times.size() == 1 || times.size() == one.size()) return;
    sizing.problem(delay, fmt::format("there are {} delays for {}", times.size(), to_string(one)));
  }

  void outputs(Now now, Out out) const override {
    const Array in = now[u], times = now[delay];
    const bool given = now.given(initial_value);
    const Array before = given ? now[initial_value] : Array(0.0);
    const int width = std::max(in.size(), before.size());
    Array delayed(width == 1 ? Shape::scalar() : Shape::vector(width));
    for (int i = 0; i < width; ++i) {
      const Value time = times.size() == 1 ? times[0] : times[i];
      if (time.is(0)) {
        delayed[i] = in.at(i);
        continue;
      }
      delayed[i] =
          now.kernel(std::make_shared<DeadTime>(!given), {time, before.at(i)}, {in.at(i), time, before.at(i)})[0];
    }
    out[y] = delayed;
  }
};

}  // namespace

PLANTLOOP_BLOCK(transport_delay, TransportDelay)

}  // namespace plantloop
