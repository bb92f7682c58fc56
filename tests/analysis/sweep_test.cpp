// Sweeps: which points there are, that threads change nothing, and that a failure stays with its point.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <mutex>
#include <set>

#include "engine/analysis/sweep.h"
#include "engine/base/error.h"
#include "engine/base/numbers.h"

namespace plantloop {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> texts_of(const SweepPlan& plan) {
  Report report;
  const auto points = sweep_points(plan, report);
  if (!points) return {to_text(report)};
  std::vector<std::string> texts;
  for (const Overrides& point : *points) {
    std::string text;
    for (const Override& o : point) text += (text.empty() ? "" : " ") + o.path + "=" + o.text;
    texts.push_back(text);
  }
  return texts;
}

constexpr const char* lag = R"(
parameters: {k: 2, tau: 0.5, n: 2}
blocks:
  x: {type: first_order, in: 1, k: k, tau: tau, initial: 0}
  noise: {type: white_noise, rate: 0.1}
  v: {type: integrator, in: noise*ones(n)}
  bound: {type: saturation, in: x, lower: 0, upper: sqrt(tau)}
simulation: {stop: 2, rtol: 1e-9, atol: 1e-11}
record: [x, v, bound]
)";

std::shared_ptr<Diagram> diagram_of(const std::string& text) {
  Report report;
  return Diagram::from_text("plantloop: 1\n" + text, "test.yaml", report);
}

TEST(SweepPoints, AreEveryCombinationWithTheLastParameterFastest) {
  SweepPlan plan;
  plan.grid = {{"a", {"1", "2"}}, {"b", {"x", "y"}}};
  EXPECT_THAT(texts_of(plan), ElementsAre("a=1 b=x", "a=1 b=y", "a=2 b=x", "a=2 b=y"));
  plan.grid.pop_back();
  plan.list = {{"c", {"3", "4"}}, {"d", {"5", "6"}}};
  EXPECT_THAT(texts_of(plan), ElementsAre("a=1 c=3 d=5", "a=1 c=4 d=6", "a=2 c=3 d=5", "a=2 c=4 d=6"));
}

TEST(SweepPoints, ThatAreDrawnDependOnSeedPathAndNumberAlone) {
  SweepPlan plan;
  plan.random = {{"a", "uniform", 1, 2}};
  plan.draws = 3;
  const auto three = texts_of(plan);
  plan.draws = 5;
  const auto five = texts_of(plan);
  EXPECT_TRUE(std::equal(three.begin(), three.end(), five.begin()));
  plan.random.insert(plan.random.begin(), {"b", "normal", 0, 1});
  const auto both = texts_of(plan);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_THAT(both[i], HasSubstr(five[i]));
  plan.seed = 2;
  EXPECT_NE(texts_of(plan), both);
}

TEST(SweepPoints, ThatAreDrawnHaveTheMomentsOfTheirDistribution) {
  SweepPlan plan;
  plan.random = {{"u", "uniform", -1, 3}, {"l", "log_uniform", 0.1, 10}, {"n", "normal", 5, 2}};
  plan.draws = 20000;
  Report report;
  const auto points = sweep_points(plan, report);
  ASSERT_TRUE(points);
  double u = 0, l = 0, n = 0, nn = 0;
  for (const Overrides& point : *points) {
    u += *parse_number(point[0].text);
    l += std::log10(*parse_number(point[1].text));
    const double z = *parse_number(point[2].text);
    n += z;
    nn += (z - 5) * (z - 5);
    EXPECT_GT(*parse_number(point[1].text), 0.1);
    EXPECT_LT(*parse_number(point[1].text), 10);
  }
  // Five standard deviations of a mean of 20000.
  const double roots = std::sqrt(20000.0);
  EXPECT_NEAR(u / 20000, 1, 5 * 4 / std::sqrt(12.0) / roots);
  EXPECT_NEAR(l / 20000, 0, 5 * 2 / std::sqrt(12.0) / roots);
  EXPECT_NEAR(n / 20000, 5, 5 * 2 / roots);
  EXPECT_NEAR(nn / 20000, 4, 5 * 4 * std::sqrt(2.0) / roots);
}

TEST(SweepPoints, ThatCannotBeAreSaid) {
  SweepPlan plan;
  EXPECT_THAT(texts_of(plan).front(), HasSubstr("the sweep has no parameters"));
  plan.list = {{"a", {"1", "2"}}, {"b", {"1"}}};
  EXPECT_EQ(texts_of(plan).front(),
            "error: the lists of a sweep go side by side: 'a' has 2 values, 'b' has 1\n  for every combination of "
            "values take a grid\n");
  plan = {};
  plan.grid = {{"a", {"1"}}, {"a", {"2"}}};
  EXPECT_EQ(texts_of(plan).front(), "error: the sweep has 'a' twice\n");
  plan = {};
  plan.grid = {{"a", {}}};
  EXPECT_EQ(texts_of(plan).front(), "error: the sweep has no values for 'a'\n");
  plan = {};
  plan.random = {{"a", "unifrom", 0, 1}};
  EXPECT_THAT(texts_of(plan).front(), HasSubstr("did you mean 'uniform'?"));
  plan.random = {{"a", "log_uniform", -1, 1}};
  EXPECT_EQ(texts_of(plan).front(),
            "error: 'a': log_uniform(-1, 1) is no distribution: it is log_uniform(lower, upper) with 0 < lower and "
            "lower <= upper\n");
}

SweepRequest request_of(const SweepPlan& plan) {
  Report report;
  SweepRequest request;
  request.points = sweep_points(plan, report).value();
  return request;
}

TEST(Sweep, GivesTheRunsInOrderWithTheBytesOfSingleRunsForAnyNumberOfThreads) {
  SweepPlan plan;
  plan.grid = {{"tau", {"0.2", "0.5", "1.5"}}, {"n", {"2", "3"}}};  // n changes the structure
  plan.random = {{"k", "uniform", 1, 3}};
  plan.draws = 4;
  SweepRequest request = request_of(plan);
  std::vector<std::string> single;
  for (const Overrides& point : request.points) {
    Report report;
    RunRequest run;
    run.set = point;
    single.push_back(to_csv(diagram_of(lag)->run(run, report)->recording));
  }
  for (const std::size_t threads : {1U, 2U, 5U}) {
    request.threads = threads;
    Report report;
    const auto diagram = diagram_of(lag);
    const auto points = sweep(*diagram, request, report);
    ASSERT_TRUE(points);
    ASSERT_EQ(points->size(), 24u);
    for (std::size_t i = 0; i < 24; ++i) {
      ASSERT_TRUE((*points)[i].run);
      EXPECT_EQ(to_csv((*points)[i].run->recording), single[i]) << i << ", " << threads << " threads";
      const double tau = *parse_number((*points)[i].set[0].text), k = *parse_number((*points)[i].set[2].text);
      EXPECT_NEAR((*points)[i].run->recording.value(0, 2), k * (1 - std::exp(-2 / tau)), 1e-7);
    }
  }
}

TEST(Sweep, CompilesOnceForAllNumbers) {
  SweepPlan plan;
  plan.random = {{"k", "uniform", 1, 3}};
  plan.draws = 200;
  const auto diagram = diagram_of(lag);
  Report report;
  std::mutex looking;
  std::set<const void*> programs;
  SweepRequest request = request_of(plan);
  request.threads = 3;
  request.finished = [&](std::size_t, SweepPoint& point) {
    Report unused;
    RunRequest run;
    run.set = point.set;
    const std::lock_guard lock(looking);
    programs.insert(diagram->prepare(run, unused)->compiled->program.get());
    point.run.reset();
  };
  ASSERT_TRUE(sweep(*diagram, request, report));
  EXPECT_EQ(programs.size(), 1u);
}

TEST(Sweep, KeepsAFailureAtItsPoint) {
  SweepPlan plan;
  plan.grid = {{"tau", {"0.5", "-1", "2"}}};
  Report report;
  const auto points = sweep(*diagram_of(lag), request_of(plan), report);
  ASSERT_TRUE(points);
  EXPECT_TRUE((*points)[0].run && (*points)[2].run);
  EXPECT_FALSE((*points)[1].run);
  EXPECT_THAT((*points)[1].failure, HasSubstr("'x.tau' is -1: it must be at least 1e-09"));
  // What fails while running: x' = x^2 ends at 1/x0.
  plan.grid = {{"x.initial", {"0.1", "1"}}};
  const auto blown = sweep(*diagram_of("blocks: {x: {type: integrator, in: x^2, initial: 0}}\nsimulation: {stop: 5}\n"),
                           request_of(plan), report);
  ASSERT_TRUE(blown);
  EXPECT_NEAR((*blown)[0].run->recording.value(0, 5), 0.2, 1e-6);
  EXPECT_FALSE((*blown)[1].run);
  EXPECT_THAT((*blown)[1].failure, HasSubstr("'x'"));
}

TEST(Sweep, WithAWrongNameIsWrongAsAWhole) {
  SweepPlan plan;
  plan.grid = {{"tua", {"1", "2"}}};
  Report report;
  EXPECT_FALSE(sweep(*diagram_of(lag), request_of(plan), report));
  EXPECT_THAT(to_text(report), HasSubstr("did you mean 'tau'?"));
}

TEST(Sweep, TellsItsProgressAndCanBeCancelled) {
  SweepPlan plan;
  plan.random = {{"k", "uniform", 1, 3}};
  plan.draws = 50;
  SweepRequest request = request_of(plan);
  request.threads = 2;
  Report report;
  std::vector<std::size_t> told;
  std::atomic<bool> cancel{false};
  const auto diagram = diagram_of(lag);
  SweepControl control{.cancel = &cancel, .progress = [&](std::size_t done, std::size_t) { told.push_back(done); }};
  ASSERT_TRUE(sweep(*diagram, request, report, control));
  EXPECT_EQ(told.size(), 50u);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  control.progress = [&](std::size_t done, std::size_t) { cancel = done >= 10; };
  EXPECT_THROW(sweep(*diagram, request, report, control), LimitError);
}

}  // namespace
}  // namespace plantloop
