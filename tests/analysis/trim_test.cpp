// Rests of diagrams against closed forms.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "engine/analysis/linearise.h"

namespace plantloop {
namespace {

using ::testing::HasSubstr;

std::optional<Trim> rest(const std::string& text, const TrimRequest& request, std::string* findings = nullptr) {
  Report report;
  const auto diagram = Diagram::from_text("plantloop: 1\n" + text, "test.yaml", report);
  auto found = trim(diagram->model_pointer(), request, report);
  if (findings) *findings = to_text(report);
  return found;
}

double value(const std::vector<Trim::Entry>& entries, const std::string& path) {
  for (const Trim::Entry& e : entries) {
    if (e.path == path) return e.value;
  }
  ADD_FAILURE() << path;
  return NAN;
}

// A tank: level' = inflow - 0.4 sqrt(level).
constexpr const char* tank = R"(
blocks:
  inflow: {type: constant, value: 0.5}
  level: {type: integrator, in: inflow - 0.4*sqrt(level), initial: 1}
simulation: {stop: 1}
)";

TEST(S16Trim, FindsTheRestOfATank) {
  const auto t = rest(tank, {});
  ASSERT_TRUE(t && t->converged) << t->why;
  EXPECT_NEAR(value(t->states, "level"), 1.25 * 1.25, 1e-10);
}

TEST(S16Trim, MovesAnInputUntilAnOutputIsAsWanted) {
  const auto t = rest(tank, {.inputs = {{"inflow"}}, .outputs = {{"level", 4}}});
  ASSERT_TRUE(t && t->converged);
  EXPECT_NEAR(value(t->inputs, "inflow"), 0.8, 1e-10);
  EXPECT_NEAR(value(t->states, "level"), 4, 1e-10);
}

TEST(S16Trim, KeepsBoundsAndSaysWhatIsLeft) {
  const auto t = rest(tank, {.inputs = {{"inflow", 0, 0.6}}, .outputs = {{"level", 4}}});
  ASSERT_TRUE(t);
  EXPECT_FALSE(t->converged);
  EXPECT_THAT(t->why, testing::Not(testing::IsEmpty()));
  EXPECT_GT(t->largest_residual, 1e-3);
}

TEST(S16Trim, HoldsAStateWhereItIsTold) {
  const auto t = rest(tank, {.inputs = {{"inflow"}}, .fixed = {{"level", 2.25}}});
  ASSERT_TRUE(t && t->converged);
  EXPECT_NEAR(value(t->inputs, "inflow"), 0.6, 1e-12);
  EXPECT_EQ(value(t->states, "level"), 2.25);
}

// A sampled controller with an integrator around a lag: at rest the error is zero and u = w.
TEST(S16Trim, ASampledLoopRestsWhenItsStatesRepeat) {
  const auto t = rest(R"(
blocks:
  e: {expr: 2 - y, rate: 0.1}
  i: {type: unit_delay, in: i + 0.1*e, rate: 0.1}
  y: {type: first_order, in: i + 0.5*e, tau: 0.3}
simulation: {stop: 1}
)",
                      {});
  ASSERT_TRUE(t && t->converged) << t->why;
  EXPECT_NEAR(value(t->states, "y"), 2, 1e-9);
  EXPECT_NEAR(value(t->states, "i"), 2, 1e-9);
}

TEST(S16Trim, SaysThatThereIsNoSuchState) {
  std::string text;
  EXPECT_FALSE(rest(tank, {.fixed = {{"levl", 1}}}, &text));
  EXPECT_THAT(text, HasSubstr("there is no state 'levl'"));
}

TEST(S16Trim, SaysWhatDoesNotRest) {
  const auto t = rest("blocks:\n  x: {type: integrator, in: 2}\nsimulation: {stop: 1}\n", {});
  ASSERT_TRUE(t);
  EXPECT_FALSE(t->converged);
  EXPECT_EQ(t->why, "'x' still changes by 2 per second");
}

}  // namespace
}  // namespace plantloop
