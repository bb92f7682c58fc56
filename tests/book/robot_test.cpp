// The robot arm of section 6.2 with other masses, poles and set points, against an independent integration.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/book/book_runs.h"
#include "tests/book/reference.h"

namespace plantloop::testing_book {
namespace {

struct OtherArm {
  double m, r, kv, speed, p;
  std::vector<double> times, heights;
};

struct Gains {
  long double K0[3], K1[3];
};

// Slow and fast pole at 0, 36 and 72 degrees; the slow one is cancelled.
Gains design(const OtherArm& a, long double J, long double G) {
  Gains g{};
  for (int i = 0; i < 3; ++i) {
    const long double root = std::sqrt(a.kv * a.kv - 4 * J * G * std::cos(i * std::numbers::pi_v<long double> / 5));
    g.K0[i] = a.speed * (a.kv + root) / 2;
    g.K1[i] = g.K0[i] * (a.kv - root) / (2 * J);
  }
  return g;
}

class ArmOfOtherNumbers : public testing::TestWithParam<OtherArm> {};

TEST_P(ArmOfOtherNumbers, MovesAsTheReferenceInEveryWayOfBlending) {
  const OtherArm& a = GetParam();
  const long double J = a.m * a.r * a.r / 3.0L, G = a.m * 9.81L * a.r / 2;
  const Gains g = design(a, J, G);
  const auto blended = [&](const long double* K, long double phi) {
    const long double y = a.r * (1 - std::cos(phi));
    const long double centres[] = {0, 0.2L, 0.7L}, widths[] = {0.15L, 0.15L, 0.25L};
    long double sum = 0, whole = 0;
    for (int i = 0; i < 3; ++i) {
      const long double d = (y - centres[i]) / widths[i], mu = std::exp(-d * d / 2);
      sum += mu * K[i], whole += mu;
    }
    return sum / whole;
  };
  std::vector<double> grid;
  for (int i = 1; i <= 48; ++i) grid.push_back(0.25 * i);
  const auto list = [](const std::vector<double>& numbers) { return fmt::format("[{}]", fmt::join(numbers, ", ")); };
  const BookRun run = run_file("diagrams/book/robot.yaml", {.set = {{"m", fmt::format("{}", a.m)},
                                                                    {"r", fmt::format("{}", a.r)},
                                                                    {"kv", fmt::format("{}", a.kv)},
                                                                    {"speed", fmt::format("{}", a.speed)},
                                                                    {"p", fmt::format("{}", a.p)},
                                                                    {"w.times", list(a.times)},
                                                                    {"w.values", list(a.heights)}},
                                                            .stop = 12,
                                                            .output_interval = 0.25});
  // States: phi, omega, z, and what the way of blending remembers.
  const auto check = [&](const char* column, const auto& control) {
    const std::vector<State> expected = integrate_pieces(
        [&](int edge, const State& x) {
          const long double wanted = std::acos(1 - a.heights[static_cast<std::size_t>(std::max(edge, 0))] / a.r);
          const long double zd = a.p * (wanted - x[0] - x[2]);
          const auto [u, remembered] = control(x, zd);
          return State{x[1], (u - G * std::sin(x[0]) - a.kv * x[1]) / J, zd, remembered};
        },
        {0, 0, 0, 0}, 0, a.times, grid);
    double worst = 0;
    for (std::size_t i = 0; i < grid.size(); ++i)
      worst = std::max(worst, std::fabs(run.at(column, grid[i]) - static_cast<double>(expected[i][0])));
    EXPECT_LT(worst, 1e-6) << column;
    RecordProperty(column, fmt::format("{:.2g}", worst));
  };
  using Pair = std::pair<long double, long double>;
  check("velocity.phi", [&](const State& x, long double zd) {
    return Pair{x[3], blended(g.K0, x[0]) * zd + blended(g.K1, x[0]) * x[2]};
  });
  check("parameters.phi", [&](const State& x, long double) {
    return Pair{blended(g.K0, x[0]) * x[2] + blended(g.K1, x[0]) * x[3], x[2]};
  });
  check("before_integral.phi", [&](const State& x, long double) {
    return Pair{blended(g.K0, x[0]) * x[2] + x[3], blended(g.K1, x[0]) * x[2]};
  });
}

INSTANTIATE_TEST_SUITE_P(Some, ArmOfOtherNumbers,
                         testing::Values(OtherArm{1, 1, 5, 2, 50, {0, 1, 7}, {0, 0.2, 0.7}},
                                         OtherArm{1.7, 1, 7, 3, 80, {0, 0.37, 4, 9.1}, {0, 0.55, 0.1, 0.8}},
                                         OtherArm{0.8, 1.4, 8, 1.2, 30, {0, 0.5, 6}, {0, 0.9, 0.3}},
                                         OtherArm{2, 0.9, 9, 2.5, 120, {0, 1, 2, 3, 4}, {0.1, 0.4, 0.15, 0.6, 0}}));

}  // namespace
}  // namespace plantloop::testing_book
