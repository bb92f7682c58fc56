// Signals that excite a process.

#include "identify/data/excitation.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "identify/data/prbs_taps.h"
#include "identify/error.h"
#include "identify/random.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double pi = std::numbers::pi;

void check_samples(Index samples) {
  if (samples < 1) fail("a signal has at least one sample, not {}", samples);
}

}  // namespace

VectorXd prbs(int bits, Index hold, double amplitude, Index samples) {
  if (bits < fewest_prbs_bits || bits > most_prbs_bits)
    fail("the register has {} to {} bits, not {}", fewest_prbs_bits, most_prbs_bits, bits);
  if (hold < 1) fail("a level lasts at least one sample, not {}", hold);
  const Index period = (Index{1} << bits) - 1;
  if (samples == 0) samples = period * hold;
  check_samples(samples);
  std::vector<int> r(static_cast<std::size_t>(bits), 1);
  VectorXd u(samples);
  for (Index k = 0; k < samples; ++k) {
    u[k] = r.back() == 1 ? amplitude : -amplitude;
    if ((k + 1) % hold != 0) continue;
    int parity = 0;
    for (const int tap : prbs_taps(bits)) {
      if (tap > 0) parity ^= r[static_cast<std::size_t>(tap - 1)];
    }
    r.insert(r.begin(), parity);
    r.pop_back();
  }
  return u;
}

VectorXd staircase(Index samples, Index hold_least, Index hold_most, double lower, double upper, std::uint64_t seed) {
  check_samples(samples);
  if (hold_least < 1 || hold_most < hold_least)
    fail("a level lasts from 1 sample on, not {} to {}", hold_least, hold_most);
  Random random(seed);
  VectorXd u(samples);
  for (Index k = 0; k < samples;) {
    const double level = random.uniform(lower, upper);
    Index hold = hold_least + static_cast<Index>(random.index(static_cast<std::uint64_t>(hold_most - hold_least + 1)));
    for (; hold > 0 && k < samples; --hold) u[k++] = level;
  }
  return u;
}

VectorXd white_noise(Index samples, double deviation, std::uint64_t seed) {
  check_samples(samples);
  Random random(seed);
  VectorXd e(samples);
  for (double& v : e) v = deviation * random.normal();
  return e;
}

VectorXd portable_noise(Index samples, double deviation, std::uint32_t seed) {
  check_samples(samples);
  if (seed < 1 || seed > 2147483646) fail("the seed lies in 1 ... 2147483646, it is {}", seed);
  ParkMiller random(seed);
  VectorXd e(samples);
  for (double& v : e) v = deviation * random.normal();
  return e;
}

VectorXd multisine(Index samples, Index period, Index first, Index last, double amplitude) {
  check_samples(samples);
  if (first < 1 || last < first || 2 * last >= period) {
    fail("the harmonics {} to {} do not lie between 1 and half of the period of {} samples", first, last, period);
  }
  const auto count = static_cast<double>(last - first + 1);
  VectorXd one(period);
  for (Index k = 0; k < period; ++k) {
    one[k] = 0;
    for (Index h = first; h <= last; ++h) {
      const auto m = static_cast<double>(h - first + 1);
      // The product modulo the period keeps the angle exact for long records.
      const double turn = static_cast<double>(h * k % period) / static_cast<double>(period);
      one[k] += std::cos(2 * pi * turn - pi * m * (m - 1) / count);
    }
  }
  one *= amplitude / one.cwiseAbs().maxCoeff();
  VectorXd u(samples);
  for (Index k = 0; k < samples; ++k) u[k] = one[k % period];
  return u;
}

VectorXd chirp(Index samples, double Ts, double from, double to, double amplitude) {
  check_samples(samples);
  if (!(Ts > 0) || !(from >= 0) || !(to >= 0) || std::max(from, to) > pi / Ts) {
    fail("the frequencies {} and {} rad/s do not lie between 0 and pi/Ts = {:.6g} rad/s", from, to, pi / Ts);
  }
  const double length = static_cast<double>(samples) * Ts;
  VectorXd u(samples);
  for (Index k = 0; k < samples; ++k) {
    const double t = static_cast<double>(k) * Ts;
    u[k] = amplitude * std::sin(from * t + (to - from) * t * t / (2 * length));
  }
  return u;
}

VectorXd square_wave(Index samples, Index half, double amplitude) {
  check_samples(samples);
  if (half < 1) fail("half a period lasts at least one sample, not {}", half);
  VectorXd u(samples);
  for (Index k = 0; k < samples; ++k) u[k] = k / half % 2 == 0 ? amplitude : -amplitude;
  return u;
}

}  // namespace plantloop::identify
