// Plant (6.2) of the book under scheduled gains: velocity form and conventional forms, figures 6.7 and 6.8.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/book/book_runs.h"
#include "tests/book/reference.h"

namespace plantloop::testing_book {
namespace {

const std::string file = "diagrams/book/gain_scheduling.yaml";
constexpr double never = std::numeric_limits<double>::infinity();

BookRun run_step(double D) { return run_file(file, {.set = {{"D", fmt::format("{}", D)}}, .max_step = 0.005}); }

void expect_answer(const BookRun& run, const std::string& column, const Step& step, const Answer& expected) {
  const Answer answer = run.answer(column, step);
  EXPECT_NEAR(answer.overshoot, expected.overshoot, 0.3) << column;  // % points; as the numbers were printed
  EXPECT_NEAR(answer.rise, expected.rise, 0.01) << column;
  if (expected.settling == never) {
    EXPECT_EQ(answer.settling, never) << column;
  } else {
    EXPECT_NEAR(answer.settling, expected.settling, 0.01) << column;
  }
}

TEST(VelocityFormLoop, IsLinearForStepsOfAnyHeight) {
  // y/w = k p/(s^2 + p s + k p): poles a and b, whose step response has a closed form.
  const double a = 50 + std::sqrt(2500 - 550.0);
  const double b = 50 - std::sqrt(2500 - 550.0);
  for (const double D : {0.05, 0.5, 2.0, 5.0}) {
    const BookRun run = run_file(file, {.set = {{"D", fmt::format("{}", D)}}, .output_interval = 0.01});
    for (int i = 0; i <= 500; ++i) {
      const double t = 0.01 * i;
      const double exact = D * (1 - (a * std::exp(-b * t) - b * std::exp(-a * t)) / (a - b));
      EXPECT_NEAR(run.at("v.y", 1 + t), exact, 1e-6) << D << " " << t;
    }
    EXPECT_LT(run_step(D).measure("error", "max_abs"), 1e-6) << D;
  }
}

TEST(VelocityFormLoop, StandsWhereComputedElsewhere) {
  for (const double D : {0.05, 0.5, 2.0, 5.0}) {
    const BookRun run = run_file(file, {.set = {{"D", fmt::format("{}", D)}}, .output_interval = 0.1});
    EXPECT_NEAR(run.at("v.y", 1.2), 0.668523 * D, 1e-6 * std::max(1.0, D));  // printed digits
    EXPECT_NEAR(run.at("v.y", 2.0), 0.996902 * D, 1e-6 * std::max(1.0, D));
  }
}

TEST(VelocityFormLoop, AsksForThePeaksComputedElsewhere) {
  EXPECT_NEAR(run_step(0.05).measure("v.u", "max"), 0.5, 1e-4);
  EXPECT_NEAR(run_step(0.5).measure("v.u", "max"), 143.58, 0.02);  // 143.584 between rows of 1/3 ms
  EXPECT_NEAR(run_step(2).measure("v.u", "max"), 874.33, 0.02);
}

TEST(GainScheduling, AnswersSmallStepsAsDesigned) {
  const BookRun run = run_step(0.05);
  const Step up{1, 6, 0, 0.05};
  const Step down{6, 12, 0.05, 0};
  for (const Step& step : {up, down}) {
    expect_answer(run, "v.y", step, {0, 0.680, 0.183});
    expect_answer(run, "c1.y", step, {0, 0.686, 0.182});
    expect_answer(run, "c3.y", step, {0, 0.678, 0.183});
  }
  expect_answer(run, "c2.y", up, {0, 0.711, 0.185});
  expect_answer(run, "c2.y", down, {0, 0.686, 0.188});
  // All four agree: the times at 63.2 % differ by less than 3 %.
  for (const char* loop : {"c1.y", "c2.y", "c3.y"}) {
    const double rise = run.answer("v.y", down).rise;
    EXPECT_NEAR(run.answer(loop, down).rise, rise, 0.03 * rise) << loop;
  }
}

TEST(GainScheduling, AnswersMediumStepsInVelocityFormOnlyAsDesigned) {
  const BookRun run = run_step(0.5);
  const Step up{1, 6, 0, 0.5};
  const Step down{6, 12, 0.5, 0};
  for (const Step& step : {up, down}) {
    expect_answer(run, "v.y", step, {0, 0.680, 0.183});
    expect_answer(run, "c1.y", step, {1.42, 0.994, 0.119});
    expect_answer(run, "c3.y", step, {17.2, 1.147, 0.310});
  }
  EXPECT_GT(run.answer("c2.y", up).overshoot, 80);
  EXPECT_EQ(run.answer("c2.y", up).settling, never);
  EXPECT_NEAR(run.answer("c2.y", up).rise, 0.116, 0.01);
  expect_answer(run, "c2.y", down, {0, 0.782, 0.281});
}

TEST(GainScheduling, AnswersLargeStepsInVelocityFormOnlyAsDesigned) {
  const BookRun run = run_step(2);
  const Step up{1, 6, 0, 2};
  const Step down{6, 12, 2, 0};
  for (const Step& step : {up, down}) {
    expect_answer(run, "v.y", step, {0, 0.680, 0.183});
    expect_answer(run, "c1.y", step, {0.49, 1.279, 0.160});
  }
  EXPECT_GT(run.answer("c2.y", up).overshoot, 80);
  EXPECT_EQ(run.answer("c2.y", up).settling, never);
  EXPECT_NEAR(run.answer("c2.y", up).rise, 0.159, 0.01);
  expect_answer(run, "c2.y", down, {0, 2.58, 1.67});
  expect_answer(run, "c3.y", up, {66.2, never, 0.90});
  expect_answer(run, "c3.y", down, {71.9, 5.76, 0.97});
}

// The loops again, written down a second time, for other gains, poles and set points.
struct OtherLoop {
  double k, p, y0;
  std::vector<double> times, set_points;
  // Whether the series form can be compared: after large steps it passes states from which neighbours part, and every
  // error becomes up to 1e7 times larger within 0.3 s.
  bool series_comparable = true;
};

long double slope(long double rho) {
  const long double c = std::cosh(std::min(std::fabs(rho), 300.0L));
  return 1 / (c * c) + 0.01L;
}

// States of each controller: y, then its own two.
State velocity_form(const OtherLoop& p, long double w, const State& x) {
  const long double rho = x[2] - 10 * x[0];
  const long double zd = p.p * (w - x[0] - x[1]);
  return {std::tanh(rho) + 0.01L * rho, zd, p.k / slope(rho) * zd + 10 * p.k * x[1]};
}
State parallel(const OtherLoop& p, long double w, const State& x, bool fixed) {
  const long double rho = x[2] - 10 * x[0];
  const long double K0 = fixed ? p.k / 1.01L : p.k / slope(rho);
  return {std::tanh(rho) + 0.01L * rho, 10 * p.k * (w - x[0]), p.p * (K0 * (w - x[0]) + x[1] - x[2])};
}
State series(const OtherLoop& p, long double w, const State& x) {
  const long double rho = x[2] - 10 * x[0];
  const long double e = w - x[0];
  return {std::tanh(rho) + 0.01L * rho, 10 * slope(rho) * e, p.p * (p.k / slope(rho) * (e + x[1]) - x[2])};
}

class LoopsOfOtherNumbers : public testing::TestWithParam<OtherLoop> {
 protected:
  static std::vector<double> grid() {
    std::vector<double> times;
    for (int i = 1; i <= 32; ++i) times.push_back(0.25 * i);
    return times;
  }

  static void compare(const RunRequest& with) {
    const OtherLoop& p = GetParam();
    const auto list = [](const std::vector<double>& numbers) { return fmt::format("[{}]", fmt::join(numbers, ", ")); };
    RunRequest request = with;
    request.set = {{"k", fmt::format("{}", p.k)},
                   {"p", fmt::format("{}", p.p)},
                   {"y0", fmt::format("{}", p.y0)},
                   {"w.times", list(p.times)},
                   {"w.values", list(p.set_points)}};
    request.stop = 8;
    request.output_interval = 0.25;
    const BookRun run = run_file(file, request);
    const std::vector<double> times = grid();
    const auto check = [&](const std::string& loop, const State& start, const auto& right_side) {
      const std::vector<State> expected = integrate_pieces(
          [&](int edge, const State& x) {
            return right_side(p, p.set_points[static_cast<std::size_t>(std::max(edge, 0))], x);
          },
          start, 0, p.times, times);
      for (std::size_t i = 0; i < times.size(); ++i) {
        EXPECT_NEAR(run.at(loop + ".y", times[i]), static_cast<double>(expected[i][0]), 1e-5) << loop << times[i];
      }
    };
    const long double y0 = p.y0;
    check("v", {y0, 0, 10 * y0}, velocity_form);
    check("c1", {y0, 10 * y0, 10 * y0}, [](const auto& q, auto w, const State& x) { return parallel(q, w, x, false); });
    check("c3", {y0, 10 * y0, 10 * y0}, [](const auto& q, auto w, const State& x) { return parallel(q, w, x, true); });
    if (p.series_comparable) check("c2", {y0, 10 * y0 * 1.01L / p.k, 10 * y0}, series);
  }
};

TEST_P(LoopsOfOtherNumbers, AgreeWithTheReference) { compare({}); }
TEST_P(LoopsOfOtherNumbers, AgreeWithTheReferenceUnderTightDopri5) { compare({.rtol = 1e-10, .atol = 1e-12}); }
TEST_P(LoopsOfOtherNumbers, AgreeWithTheReferenceUnderBdf) { compare({.rtol = 1e-10, .atol = 1e-12, .solver = "bdf"}); }

INSTANTIATE_TEST_SUITE_P(Some, LoopsOfOtherNumbers,
                         testing::Values(OtherLoop{5.5, 100, 0, {0, 1, 6}, {0, 0.5, 0}},
                                         OtherLoop{3, 60, 0.4, {0, 0.5, 3, 5.25}, {0.4, 1.1, -0.2, 0.3}},
                                         OtherLoop{8, 200, -1, {0, 1, 4}, {-1, 0.7, -0.5}, false},
                                         OtherLoop{1.2, 25, 0, {0, 0.3333, 4.7}, {0, 3, 1}},
                                         OtherLoop{5.5, 50, 0.1, {0, 2}, {0.1, 0.12}}));

}  // namespace
}  // namespace plantloop::testing_book
