// Random levels, each held for a number of samples.

#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/block.h"
#include "engine/block_algebra.h"
#include "engine/program/kernel.h"

namespace plantloop {
namespace {

constexpr double lcg_modulus = 2147483647;

// The finaliser of SplitMix64 (G. Steele, D. Lea, C. Flood 2014).
std::uint64_t mix(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

// A whole number as 64 bits; negative ones too (a run may start before time 0). Beyond 63 bits any bits will do.
std::uint64_t whole(double v) {
  if (std::fabs(v) < 0x1p63) return static_cast<std::uint64_t>(static_cast<std::int64_t>(v));
  return std::bit_cast<std::uint64_t>(v);
}

// A pure function of seed, stream, element and level, with values in (0, 1).
class CounterRandom final : public Kernel {
 public:
  CounterRandom(std::uint64_t stream, int width) : stream_(stream), width_(width) {}
  std::string name() const override { return "random levels"; }
  int outputs() const override { return width_; }
  void evaluate(const KernelCall& call) const override {
    const std::uint64_t seed = whole(call.in[0]), level = whole(call.in[1]);
    for (int i = 0; i < width_; ++i) {
      const std::uint64_t bits = mix(mix(mix(mix(seed) ^ stream_) + static_cast<std::uint64_t>(i)) + level);
      call.out[i] = (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
    }
  }

 private:
  std::uint64_t stream_;
  int width_;
};

struct RandomLevels final : Block {
  static constexpr auto summary = "Give random levels, evenly distributed, each held for some samples.";
  static constexpr auto details =
      "y = lower + (upper - lower) r_k, a new r_k in (0, 1) every `hold` samples.  generator counter: r is a function "
      "of "
      "the seed, of the block's path and of the number of the level (mix of SplitMix64), so blocks differ without "
      "seeds.  "
      "generator lcg: x <- 16807 x mod 2147483647 from x = seed, r = x/2147483647 (S. Park and K. Miller 1988), the "
      "same "
      "numbers in every language.";

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
    const auto given = checking.of(seed);
    if (given.empty()) return;
    if (given[0] != std::floor(given[0])) checking.problem(seed, "a seed is a whole number");
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
    const std::vector<Value> r =
        now.kernel(std::make_shared<CounterRandom>(now.stream(), span.size()), {now[seed][0], level});
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
