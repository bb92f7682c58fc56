// Random levels, each held for a number of samples.

#include <vector>

#include "engine/block.h"
#include "engine/block_algebra.h"
#include "engine/block_random.h"

namespace plantloop {
namespace {

constexpr double lcg_modulus = 2147483647;

struct RandomLevels final : Block {
  static constexpr auto summary = "Give random levels, evenly distributed, each held for some samples.";
  static constexpr auto details =
      "y = lower + (upper - lower) r_k, a new r_k in (0, 1) every `hold` samples.  generator counter: r is a function "
      "of the seed, of the block's path and of the number of the level (mix of SplitMix64), so blocks differ without "
      "seeds.  generator lcg: x <- 16807 x mod 2147483647 from x = seed, r = x/2147483647 (S. Park and K. Miller "
      "1988), the same numbers in every language.";
  static constexpr auto example = R"(
blocks: {u: {type: random_levels, lower: -1, upper: 1, hold: 5, rate: 0.1}}
simulation: {stop: 10}
expect: [{signal: u, max_abs: 1}]
)";

  Number lower{this, "lower", {.init = 0, .doc = "least value"}};
  Number upper{this, "upper", {.init = 1, .doc = "greatest value"}};
  Count hold{this, "hold", {.init = 1, .doc = "samples that each level lasts", .min = 1}};
  Number seed{this,
              "seed",
              {.init = 1,
               .doc = "where the numbers start: a whole number; of lcg from 1 to 2147483646",
               .min = 0,
               .max = 9007199254740992,
               .size = scalar}};
  Choice generator{this, "generator", {.of = {"counter", "lcg"}, .doc = "how the numbers are made"}};
  Discrete x{this, "x", {.doc = "the state of lcg", .size = scalar}};
  Discrete age{this, "age", {.doc = "samples since the last change; of lcg", .size = scalar}};
  Output y{this, "y", {.doc = "the levels"}};

  void check(Checking& checking) const override {
    check_order(checking, lower, upper, false);
    check_seed(checking, seed);
    const auto given = checking.of(seed);
    if (given.empty()) return;
    if (generator.is("lcg") && (given[0] < 1 || given[0] >= lcg_modulus)) {
      checking.problem(seed, "the seed of lcg is a whole number from 1 to 2147483646");
    }
  }

  void initial(Now now, Init init) const override {
    if (generator.is("lcg")) init[x] = advance(now[seed][0]);
  }

  void outputs(Now now, Out out) const override {
    const Array span = now[upper] - now[lower];
    if (generator.is("lcg")) {
      out[y] = now[lower] + span * (now[x] / lcg_modulus);
      return;
    }
    // One stream for each element.
    const Value level = floor(now.hit() / static_cast<double>(hold.value()));
    const std::vector<Value> r = random_numbers(now, Distribution::uniform, now[seed][0], level, span.size());
    Array levels(span.shape());
    for (int i = 0; i < levels.size(); ++i) levels[i] = r[static_cast<std::size_t>(i)];
    out[y] = now[lower] + span * levels;
  }

  void update(Now now, Next next) const override {
    if (!generator.is("lcg")) return;
    const Truths full = now[age] >= hold.value() - 1.0;
    next[age] = where(full, 0.0, now[age] + 1.0);
    next[x] = where(full, Array(advance(now[x][0])), now[x]);
  }

 private:
  // Exact in doubles: the product stays below 2^53.
  static Value advance(Value before) { return mod(16807.0 * before, Value(lcg_modulus)); }
};

}  // namespace

PLANTLOOP_BLOCK(random_levels, RandomLevels)

}  // namespace plantloop
