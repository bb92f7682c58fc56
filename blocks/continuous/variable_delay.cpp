// A dead time that changes along the run.

#include <algorithm>

#include "engine/block.h"
#include "engine/block_delay.h"

namespace plantloop {
namespace {

struct VariableDelay final : Block {
  static constexpr auto summary = "Delay the input by a time that is a signal.";
  static constexpr auto details =
      "y(t) = u(t - d(t)), where d is the delay kept between `shortest` and `longest`; before the start u was "
      "`initial`, by default its value at the start. The instants at which a jump or a kink of the input comes out are "
      "located. No step is longer than `shortest`; where that is 0, what the last step does not reach is interpolated "
      "with the present input, so a loop without states is then an algebraic one. Without `longest` the whole past "
      "is kept.";
  static constexpr auto example = R"(
blocks:
  u: {type: sine}
  late: {type: variable_delay, in: {u: u, delay: 0.5 + 0.1*time}, longest: 1}
simulation: {stop: 2}
expect: [{signal: late, at: 1, value: sin(0.4), abs: 1e-6}]
)";

  Input u{this, "u", {.doc = "signal to delay"}};
  Input delay{this, "delay", {.doc = "the dead time; one for each element of a vector, or one for all", .unit = "s"}};
  Table shortest{this,
                 "shortest",
                 {.init = "0", .unit = "s", .doc = "least delay; limits the steps", .zeros_matter = true, .min = 0}};
  Number longest{
      this,
      "longest",
      {.init = unbounded, .unit = "s", .doc = "greatest delay; what is older is forgotten", .min = 0, .size = scalar}};
  Number initial_value{this,
                       "initial",
                       {.doc = "input before the start; default: the input at the start; may read signals",
                        .optional = true,
                        .initial = true}};
  Output y{this, "y", {.doc = "the delayed signal"}};

  RateKind rate_kind() const override { return RateKind::continuous; }

  void sizes(Sizing& sizing) const override {
    if (sizing.of(shortest).is_known() && sizing.of(shortest).size() != 1)
      sizing.problem(shortest, "it must be one number");
  }

  void check(Checking& checking) const override {
    const std::vector<double> least = checking.of(shortest), most = checking.of(longest);
    if (least.size() == 1 && most.size() == 1 && least[0] > most[0])
      checking.problem(shortest, "it must not be greater than 'longest'");
  }

  void outputs(Now now, Out out) const override {
    const Array in = now[u], times = now[delay];
    const bool given = now.given(initial_value);
    const Array before = given ? now[initial_value] : Array(0.0);
    const Value least = now[shortest][0], most = now[longest][0];
    const int width = std::max({in.size(), times.size(), before.size()});
    Array late(width == 1 ? Shape::scalar() : Shape::vector(width));
    for (int i = 0; i < width; ++i) {
      DeadTime time;
      time.delay = min(max(times.at(i), least), most);
      time.shortest = least;
      time.longest = most;
      if (given) time.past = before.at(i);
      time.reads_present = least.is(0);
      late[i] = delayed(now, in.at(i), time);
    }
    out[y] = late;
  }
};

}  // namespace

PLANTLOOP_BLOCK(variable_delay, VariableDelay)

}  // namespace plantloop
