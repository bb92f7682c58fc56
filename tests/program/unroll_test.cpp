// A whole step as one list against the step made of calls.

#include <cmath>

#include "tests/program/random_equations.h"

namespace plantloop::testing_programs {
namespace {

struct Method {
  const char* name;
  std::vector<double> a, b;
};
const Method methods[] = {
    {"euler", {0}, {1}}, {"heun", {0, 1}, {0.5, 0.5}}, {"rk4", {0, 0.5, 0.5, 1}, {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6}}};

// The step by calls of the derivatives, for methods whose stages read the one before only.
std::vector<double> step_by_calls(Evaluation& evaluation, const Method& method, double t, double h) {
  const std::size_t n = evaluation.frame().state_count();
  const auto& place = evaluation.frame().program->place_of_state;
  std::vector<double> start(n), end(n), k(n);
  for (std::size_t i = 0; i < n; ++i) start[i] = end[i] = evaluation.frame().states()[place[i]];
  for (std::size_t s = 0; s < method.a.size(); ++s) {
    for (std::uint32_t i = 0; i < n; ++i) evaluation.set_state(i, start[i] + method.a[s] * h * k[i]);
    evaluation.set_time(t + method.a[s] * h);
    k = evaluation.derivatives();
    for (std::size_t i = 0; i < n; ++i) end[i] += method.b[s] * h * k[i];
  }
  for (std::uint32_t i = 0; i < n; ++i) evaluation.set_state(i, start[i]);
  evaluation.set_time(t);
  return end;
}

TEST(UnrolledStep, IsTheStepMadeOfCallsToRounding) {
  for (const Method& method : methods) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      std::mt19937 random(seed);
      Recorder recorder;
      const RandomEquations made = random_equations(recorder, random, {.layers = 12, .width = 3, .smooth = true});
      for (std::size_t i = 0; i < 4; ++i)
        recorder.record.states[i].derivative = tanh(made.values[made.values.size() - 1 - i]);
      const double h = 0.01;
      const auto program = compiled(recorder, {}, {}, method.name, h);
      ASSERT_FALSE(program->step_list.empty());
      Evaluation evaluation(program);
      set_leaves(evaluation);
      evaluation.settle();
      const auto expected = step_by_calls(evaluation, method, 1.75, h);
      execute(program->step_list, evaluation.frame().arena);
      for (std::size_t i = 0; i < 4; ++i) {
        const double found = evaluation.frame().arena[program->step_list.roots[program->place_of_state[i]]];
        // Products with h are grouped differently: a few roundings, enlarged where equations are steep.
        EXPECT_NEAR(found, expected[i], 1e-11) << method.name << ", seed " << seed;
      }
    }
  }
}

TEST(UnrolledStep, FreezesModesAsTheStepMadeOfCallsDoes) {
  // |x| beyond its kink inside the step: the mode of the start holds throughout.
  Recorder recorder;
  const StateIn x = add_state(recorder, "x");
  recorder.record.states[x.index].derivative = -3.0 + abs(x.value);
  const auto program = compiled(recorder, {}, {}, "heun", 1);
  Evaluation evaluation(program);
  evaluation.set_state(x.index, 1);
  evaluation.settle();
  execute(program->step_list, evaluation.frame().arena);
  // k1 = -2, k2 = -3 + (1 - 2) = -4.
  EXPECT_EQ(evaluation.frame().arena[program->step_list.roots[0]], 1 - 3);
}

TEST(UnrolledStep, IsMadeForSmallModelsAndMethodsOfThisShapeOnly) {
  const auto has_step = [](int states, const std::string& method) {
    Recorder recorder;
    for (int i = 0; i < states; ++i) {
      const StateIn x = add_state(recorder, "x" + std::to_string(i));
      recorder.record.states[x.index].derivative = sin(x.value) + cos(x.value);
    }
    return !compiled(recorder, {}, {}, method, 0.1)->step_list.empty();
  };
  EXPECT_TRUE(has_step(10, "rk4"));
  EXPECT_FALSE(has_step(10, "dopri5"));
  EXPECT_FALSE(has_step(1000, "rk4"));
  EXPECT_FALSE(has_step(0, "rk4"));
}

}  // namespace
}  // namespace plantloop::testing_programs
