// What compares or rounds a continuous signal becomes a mode: frozen while integrating, guarded by functions that cross
// zero where it changes.

#include <cmath>
#include <functional>

#include "tests/program/programs.h"

namespace plantloop::testing_programs {
namespace {

using Unary = std::function<Value(Value)>;

std::size_t modes_of(const Unary& f, bool plain = false) {
  Recorder recorder;
  const StateIn x = add_state(recorder, "x");
  recorder.plain = plain;
  recorder.record.states[x.index].derivative = f(x.value);
  return compiled(recorder)->modes.size();
}

const std::vector<std::pair<const char*, Unary>>& kinks() {
  static const std::vector<std::pair<const char*, Unary>> all{
      {"abs", [](Value x) { return abs(x); }},
      {"min", [](Value x) { return min(x, Value(1)); }},
      {"max", [](Value x) { return max(x, Value(1)); }},
      {"sign", [](Value x) { return sign(x); }},
      {"floor", [](Value x) { return floor(x); }},
      {"ceil", [](Value x) { return ceil(x); }},
      {"round", [](Value x) { return round(x); }},
      {"trunc", [](Value x) { return trunc(x); }},
      {"mod", [](Value x) { return mod(x, Value(1.5)); }},
      {"mod of a negative number", [](Value x) { return mod(x, Value(-1.5)); }},
      {"less", [](Value x) { return where(x < 1.0, Value(2), Value(3)); }},
      {"less_equal", [](Value x) { return where(x <= 1.0, Value(2), Value(3)); }},
      {"equal", [](Value x) { return where(equal(x, Value(1)), Value(2), Value(3)); }},
  };
  return all;
}

TEST(Modes, AreMadeOfEveryKinkOfAContinuousSignal) {
  for (const auto& [name, f] : kinks()) EXPECT_GE(modes_of(f), 1u) << name;
}

TEST(Modes, AreNotMadeWhereCrossingsAreSwitchedOff) {
  for (const auto& [name, f] : kinks()) EXPECT_EQ(modes_of(f, true), 0u) << name;
}

TEST(Modes, AreNotMadeOfParametersOrHeldSignals) {
  for (const auto& [name, f] : kinks()) {
    Recorder recorder;
    const RateIndex rate = recorder.add_rate(*Rational::from_text("0.1"), {});
    const StateIn d = add_discrete(recorder, "d", rate);
    const StateIn x = add_state(recorder, "x");
    recorder.rate = rate;
    const Value sampled = f(x.value);  // a discrete block's reading of a continuous signal
    recorder.rate = 0;
    const auto program = compiled(recorder, {f(d.value), f(recorder.parameter("p", 0.3)), f(Value(2.5)), sampled});
    EXPECT_EQ(program->modes.size(), 0u) << name;
    EXPECT_EQ(program->guards.size(), 0u) << name;
  }
}

TEST(Modes, AreNotMadeOfSmoothOperations) {
  EXPECT_EQ(modes_of([](Value x) { return sin(x) * exp(x) / (2.0 + cos(x)) - pow(x, Value(2)); }), 0u);
}

TEST(Modes, OfOneComparisonAreShared) {
  EXPECT_EQ(modes_of([](Value x) { return where(x < 1.0, Value(2), x) + where(x < 1.0, x, Value(5)); }), 1u);
}

TEST(Modes, GiveTheValueOfTheOperationWhenSettled) {
  for (const auto& [name, f] : kinks()) {
    for (const double at : {-3.75, -1.5, -1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0, 1.25, 1.5, 2.5, 7.0}) {
      Recorder recorder;
      const StateIn x = add_state(recorder, "x");
      recorder.record.states[x.index].derivative = f(x.value);
      Evaluation evaluation(compiled(recorder));
      evaluation.set_state(x.index, at);
      evaluation.settle();
      EXPECT_EQ(evaluation.derivatives()[0], f(Value(at)).number()) << name << " at " << at;
    }
  }
}

TEST(Modes, StayWhileTheSignalMovesAndSomeGuardHasChangedItsSignWhenTheyShould) {
  for (const auto& [name, f] : kinks()) {
    if (std::string(name) == "equal") continue;  // at one point only
    for (double from = -3.3; from < 3; from += 0.37) {
      for (double to = -3.1; to < 3; to += 0.41) {
        Recorder recorder;
        const StateIn x = add_state(recorder, "x");
        recorder.record.states[x.index].derivative = f(x.value);
        Evaluation evaluation(compiled(recorder));
        const Program& program = *evaluation.frame().program;
        double* const arena = evaluation.frame().arena;
        const auto guards = [&] {
          execute(program.guard_list, arena);
          std::vector<bool> positive;
          for (const auto slot : program.guard_list.roots) positive.push_back(arena[slot] > 0);
          return positive;
        };
        evaluation.set_state(x.index, from);
        evaluation.settle();
        std::vector<double> modes;
        for (const auto slot : program.modes) modes.push_back(arena[slot]);
        const auto before = guards();
        evaluation.set_state(x.index, to);
        const auto after = guards();
        execute(program.mode_list, arena);
        bool changes = false;
        for (std::size_t m = 0; m < modes.size(); ++m)
          changes = changes || arena[program.mode_list.roots[m]] != modes[m];
        EXPECT_TRUE(!changes || before != after) << name << " from " << from << " to " << to;
      }
    }
  }
}

}  // namespace
}  // namespace plantloop::testing_programs
