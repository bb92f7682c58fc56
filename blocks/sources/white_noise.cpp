// Normal random numbers.

#include "engine/block.h"
#include "engine/block_random.h"

namespace plantloop {
namespace {

struct WhiteNoise final : Block {
  static constexpr auto summary = "Give normally distributed random numbers, a new one at each sample.";
  static constexpr auto details =
      "y[k] = mean + deviation n[k], n normal with mean 0 and variance 1, independent of all others. n is a function "
      "of the seed, of the block's path and of k: the same in every run, whatever else the diagram holds, and "
      "different between blocks without seeds.";
  static constexpr auto example = R"(
blocks: {n: {type: white_noise, mean: 5, deviation: 0.1, rate: 0.01}}
simulation: {stop: 10}
expect: [{signal: n, measure: rms, value: 5, abs: 0.05}]
)";

  Number mean{this, "mean", {.init = 0, .doc = "mean"}};
  Number deviation{this, "deviation", {.init = 1, .doc = "standard deviation, the root of the variance", .min = 0}};
  Number seed{
      this,
      "seed",
      {.init = 1, .doc = "another whole number, another sequence", .min = 0, .max = 9007199254740992, .size = scalar}};
  Output y{this, "y", {.doc = "the noise"}};

  RateKind rate_kind() const override { return RateKind::discrete; }
  void check(Checking& checking) const override { check_seed(checking, seed); }
  void outputs(Now now, Out out) const override {
    Array noise = now[mean] + now[deviation];
    const auto normal = random_numbers(now, Distribution::normal, now[seed][0], now.hit(), noise.size());
    for (int i = 0; i < noise.size(); ++i) {
      noise[i] = now[mean].at(i) + now[deviation].at(i) * normal[static_cast<std::size_t>(i)];
    }
    out[y] = noise;
  }
};

}  // namespace

PLANTLOOP_BLOCK(white_noise, WhiteNoise)

}  // namespace plantloop
