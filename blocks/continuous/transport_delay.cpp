// A dead time.

#include <fmt/format.h>

#include <algorithm>

#include "engine/block.h"
#include "engine/block_delay.h"

namespace plantloop {
namespace {

struct TransportDelay final : Block {
  static constexpr auto summary = "Delay the input by a time.";
  static constexpr auto details =
      "y(t) = u(t - delay); before the start u was `initial`, by default its value at the start. Where the delay is 0, "
      "y = u. A loop through the block needs `initial`, since u at the start then depends on y. What happens to the "
      "input, a jump or a kink, comes out one delay later: the solver ends a step there, so delay equations are as "
      "accurate as the solver is on smooth ones. As a rule no step is longer than the delay. With `short_delay: "
      "feedthrough` steps may be: what the last step does not reach is interpolated with the present input, which "
      "costs accuracy and makes a loop without states an algebraic one.";
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
  Choice short_delay{this,
                     "short_delay",
                     {.of = {"limit", "feedthrough"},
                      .doc = "a delay shorter than a step would be: limit the steps to it, or read the present input"}};
  Output y{this, "y", {.doc = "the delayed signal"}};

  RateKind rate_kind() const override { return RateKind::continuous; }

  void sizes(Sizing& sizing) const override {
    const Shape one = sizing.of(y), times = sizing.of(delay);
    if (!one.is_known() || !times.is_known() || times.size() == 1 || times.size() == one.size()) return;
    sizing.problem(delay, fmt::format("there are {} delays for {}", times.size(), to_string(one)));
  }

  void check(Checking& checking) const override {
    const std::vector<double> times = checking.of(delay);
    if (std::find(times.begin(), times.end(), 0.0) != times.end())
      checking.note(delay, "zero-delay", "a delay of 0 s is none: the output is the input at the same instant");
  }

  void outputs(Now now, Out out) const override {
    const Array in = now[u], times = now[delay];
    const bool given = now.given(initial_value);
    const Array before = given ? now[initial_value] : Array(0.0);
    const int width = std::max(in.size(), before.size());
    Array late(width == 1 ? Shape::scalar() : Shape::vector(width));
    for (int i = 0; i < width; ++i) {
      DeadTime time;
      time.delay = times.size() == 1 ? times[0] : times[i];
      if (given) time.past = before.at(i);
      time.reads_present = short_delay.is("feedthrough");
      late[i] = time.delay.is(0) ? in.at(i) : delayed(now, in.at(i), time);
    }
    out[y] = late;
  }
};

}  // namespace

PLANTLOOP_BLOCK(transport_delay, TransportDelay)

}  // namespace plantloop
