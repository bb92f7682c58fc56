// White noise of a given density, as far as samples can be.

#include "engine/block.h"
#include "engine/block_random.h"

namespace plantloop {
namespace {

struct BandLimitedNoise final : Block {
  static constexpr auto summary = "Give band-limited white noise of a given power density.";
  static constexpr auto details =
      "y[k] = sqrt(power/T) n[k], held for the period T, n normal with mean 0 and variance 1. Up to about 1/T of "
      "angular frequency its two-sided power spectral density is `power`, as of continuous white noise, so a slower "
      "system answers in the same way whatever T is: the integral of y has the variance power time. n is made as of "
      "white_noise.";
  static constexpr auto example = R"(
title: White noise through a lag has the variance power/(2 tau)
blocks:
  n: {type: band_limited_noise, power: 0.2, rate: 0.01}
  x: {type: first_order, in: n, tau: 0.1}
simulation: {stop: 100}
expect: [{signal: x, measure: rms, value: 1, abs: 0.1}]
)";

  Number power{
      this, "power", {.init = 0.1, .doc = "power spectral density: square of the signal's unit, times s", .min = 0}};
  Number seed{
      this,
      "seed",
      {.init = 1, .doc = "another whole number, another sequence", .min = 0, .max = 9007199254740992, .size = scalar}};
  Output y{this, "y", {.doc = "the noise"}};

  RateKind rate_kind() const override { return RateKind::discrete; }
  void check(Checking& checking) const override { check_seed(checking, seed); }
  void outputs(Now now, Out out) const override {
    Array noise = sqrt(now[power] / now.period());
    const auto normal = random_numbers(now, Distribution::normal, now[seed][0], now.hit(), noise.size());
    for (int i = 0; i < noise.size(); ++i) noise[i] = noise[i] * normal[static_cast<std::size_t>(i)];
    out[y] = noise;
  }
};

}  // namespace

PLANTLOOP_BLOCK(band_limited_noise, BandLimitedNoise)

}  // namespace plantloop
