// The gas-liquid separator of section 6.3 at other levels, pressures and steps, and with a programmable controller,
// against an independent integration.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/book/book_runs.h"
#include "tests/book/reference.h"

namespace plantloop::testing_book {
namespace {

using Real = long double;

Real clamp01(Real x) { return std::clamp(x, Real(0), Real(1)); }

// States: v1, h, p, ps.
struct Vessel {
  Real k1 = 0.0442L, S1 = 0.5L;
  static Real inflow(Real p) { return 8e-3L - 2e-3L * p - 3e-3L * p * p; }
  Real u1_at_rest(Real p) const { return 1 + std::log(inflow(p) / (k1 * std::sqrt(p))) / std::log(25.0L); }
  static Real u2_at_rest(Real p, Real h) {
    return 1 + std::log(2e-3L / (0.0125L * std::sqrt(p + 0.0981L * h))) / std::log(25.0L);
  }
  State rates(const State& x, Real u1, Real u2) const {
    const Real p = x[2], h = x[1];
    const Real gas = k1 * std::pow(25.0L, x[0] - 1) * std::sqrt(p);
    const Real rise = 2e-3L - 0.0125L * std::pow(25.0L, u2 - 1) * std::sqrt(p + 0.0981L * h);
    return {(u1 - x[0]) / 2, rise / S1, (inflow(p) - gas + (1 + p) * rise) / (S1 * (2 - h)), p - x[3]};
  }
};

Real gain_at(Real h) {
  const Real s = std::clamp(h, Real(1), Real(1.8L));
  const Real low = -1.988272L, middle = -1.192963L, high = -0.397654L;
  return s < 1.4L ? low + (middle - low) * (s - 1) / 0.4L : middle + (high - middle) * (s - 1.4L) / 0.4L;
}
constexpr Real K1 = -0.0447361L;

struct OtherLevel {
  double p0, h0, D, k1, S1;
  std::vector<double> level_times, levels;
};

class SeparatorOfOtherNumbers : public testing::TestWithParam<OtherLevel> {};

TEST_P(SeparatorOfOtherNumbers, MovesAsTheReference) {
  const OtherLevel& a = GetParam();
  const Vessel vessel{a.k1, a.S1};
  const auto list = [](const std::vector<double>& numbers) { return fmt::format("[{}]", fmt::join(numbers, ", ")); };
  const BookRun run = run_text(fmt::format(R"(plantloop: 1
import: [diagrams/parts/separator.yaml]
blocks:
  w: {{type: staircase, times: [0, 30], values: [{0}, {0} + {1}]}}
  wh: {{type: staircase, times: {2}, values: {3}}}
  loop: {{type: pressure_loop, in: {{w: w, wh: wh}}, p_start: {0}, h_start: {4}, k1: {5}, S1: {6}}}
simulation: {{stop: 250, rtol: 1e-9, atol: 1e-11, output_interval: 5}}
record: [loop.p, loop.h]
)",
                                           a.p0, a.D, list(a.level_times), list(a.levels), a.h0, a.k1, a.S1));
  std::vector<double> edges{0, 30}, grid;
  edges.insert(edges.end(), a.level_times.begin(), a.level_times.end());
  std::sort(edges.begin(), edges.end());
  for (int i = 1; i <= 50; ++i) grid.push_back(5.0 * i);
  // And the integrals of both controllers.
  const State start{vessel.u1_at_rest(a.p0), a.h0, a.p0, a.p0, vessel.u1_at_rest(a.p0), Vessel::u2_at_rest(a.p0, a.h0)};
  const std::vector<State> expected = integrate_pieces(
      [&](int edge, const State& x) {
        const double now = edge < 0 ? 0 : edges[static_cast<std::size_t>(edge)];
        Real level = a.levels[0];
        for (std::size_t i = 0; i < a.levels.size(); ++i) {
          if (a.level_times[i] <= now) level = a.levels[i];
        }
        const Real e = a.p0 + (now >= 30 ? a.D : 0.0) - x[3], off = x[1] - level;
        const Real raw = gain_at(x[1]) * e + x[4], push = K1 * e;
        State rate = vessel.rates(x, clamp01(raw), clamp01(2 * off + x[5]));
        rate.push_back((raw > 1 && push > 0) || (raw < 0 && push < 0) ? 0 : push);
        rate.push_back(0.02L * off);
        return rate;
      },
      start, 0, edges, grid);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    EXPECT_NEAR(run.at("loop.p", grid[i]), static_cast<double>(expected[i][2]), 1e-6) << grid[i];
    EXPECT_NEAR(run.at("loop.h", grid[i]), static_cast<double>(expected[i][1]), 1e-6) << grid[i];
  }
}

INSTANTIATE_TEST_SUITE_P(Some, SeparatorOfOtherNumbers,
                         testing::Values(OtherLevel{0.5, 1.8, 0.05, 0.0442, 0.5, {0}, {1.8}},
                                         OtherLevel{0.62, 1.15, -0.11, 0.0442, 0.5, {0, 60}, {1.15, 1.55}},
                                         OtherLevel{0.41, 1.6, 0.09, 0.0442, 0.5, {0, 20, 120}, {1.6, 1.3, 1.7}},
                                         OtherLevel{0.5, 1.4, 0.05, 0.0530, 0.4, {0}, {1.4}},
                                         OtherLevel{0.5, 1.3, -0.08, 0.0354, 0.6, {0, 100}, {1.3, 1.45}}));

struct OtherPlc {
  double p0, h0, D, Ts;
};

class PlcOfOtherNumbers : public testing::TestWithParam<OtherPlc> {};

TEST_P(PlcOfOtherNumbers, StaysWithinTwoCodesOfTheReference) {
  const OtherPlc& a = GetParam();
  const Vessel vessel;
  const Real code_p = 1.5L / 4095, code_h = 2.0L / 4095, code_u = 1.0L / 4095;
  const auto count = static_cast<int>(std::lround(120 / a.Ts));
  const BookRun run = run_file("diagrams/book/separator_hil.yaml", {.set = {{"p0", fmt::format("{}", a.p0)},
                                                                            {"h0", fmt::format("{}", a.h0)},
                                                                            {"D", fmt::format("{}", a.D)},
                                                                            {"Ts", fmt::format("{}", a.Ts)}},
                                                                    .stop = 120,
                                                                    .output_interval = a.Ts});
  State x{vessel.u1_at_rest(a.p0), a.h0, a.p0, a.p0, Vessel::u2_at_rest(a.p0, a.h0)};
  Real I = x[0], applied = std::round(x[0] / code_u) * code_u, next = applied;
  double worst = 0;
  for (int k = 0; k < count; ++k) {
    const double t = k * a.Ts;
    worst = std::max(worst, std::fabs(run.at("plant.p", t) - static_cast<double>(x[2])));
    applied = next;
    const Real wanted = a.p0 + (t >= 50 - 1e-9 ? a.D : 0.0);
    const Real e = wanted - std::round(x[3] / code_p) * code_p, level = std::round(x[1] / code_h) * code_h;
    next = std::round(clamp01(gain_at(level) * e + I) / code_u) * code_u;
    I += a.Ts * K1 * e;
    x = integrate(
        [&](Real, const State& s) {
          const Real off = s[1] - a.h0;
          State rate = vessel.rates(s, applied, clamp01(2 * off + s[4]));
          rate.push_back(0.02L * off);
          return rate;
        },
        x, t, t + a.Ts, 1e-12L);
  }
  EXPECT_LT(worst, 2 * static_cast<double>(code_p));
  EXPECT_LT(worst, 1e-6);  // as long as no reading lies within rounding of a code's border
}

INSTANTIATE_TEST_SUITE_P(Some, PlcOfOtherNumbers,
                         testing::Values(OtherPlc{0.5, 1.8, 0.05, 0.5}, OtherPlc{0.63, 1.27, -0.08, 0.25},
                                         OtherPlc{0.44, 1.55, 0.12, 1}));

}  // namespace
}  // namespace plantloop::testing_book
