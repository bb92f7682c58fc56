// When an operation runs: once for parameters, at hits for held values, else whenever it is asked for.

#include "tests/program/programs.h"

namespace plantloop::testing_programs {
namespace {

TEST(Masks, OperationsOfParametersOnlyRunOnce) {
  Recorder recorder;
  const Value p = recorder.parameter("p", 3);
  const StateIn x = add_state(recorder, "x");
  recorder.record.states[x.index].derivative = sin(p * p + 1.0) * x.value;
  const auto program = compiled(recorder);
  EXPECT_EQ(program->derivative_list.operation_count, 1u);  // the product with the state
  EXPECT_EQ(program->parameter_list.operation_count, 3u);
  Evaluation evaluation(program);
  evaluation.set_state(x.index, 2);
  evaluation.settle();
  EXPECT_EQ(evaluation.derivatives()[0], 2 * std::sin(10.0));
  evaluation.frame().set_parameter(0, 1);
  evaluation.settle();
  EXPECT_EQ(evaluation.derivatives()[0], 2 * std::sin(2.0));
}

TEST(Masks, OperationsOfHeldValuesRunAtTheHitsOfTheirRateOnly) {
  Recorder recorder;
  const RateIndex fast = recorder.add_rate(*Rational::from_text("0.1"), {});
  const RateIndex slow = recorder.add_rate(*Rational::from_text("0.2"), {});
  const StateIn a = add_discrete(recorder, "a", fast), b = add_discrete(recorder, "b", slow);
  const StateIn x = add_state(recorder, "x");
  recorder.record.states[x.index].derivative = x.value + exp(a.value) + exp(b.value);
  const auto program = compiled(recorder);
  Evaluation evaluation(program);
  double* const arena = evaluation.frame().arena;
  evaluation.settle();
  evaluation.set_discrete(a.index, 1);
  evaluation.set_discrete(b.index, 2);
  EXPECT_EQ(evaluation.derivatives()[0], 2) << "nothing held has run yet";
  execute(program->held_list, arena, nullptr, rate_bit(fast));
  EXPECT_EQ(evaluation.derivatives()[0], std::exp(1.0) + 1);
  execute(program->held_list, arena, nullptr, rate_bit(slow));
  EXPECT_EQ(evaluation.derivatives()[0], std::exp(1.0) + std::exp(2.0));
  EXPECT_EQ(program->derivative_list.operation_count, 2u);  // the two sums
}

TEST(Masks, AContinuousSignalReadByADiscreteBlockIsSampledAtItsHits) {
  Recorder recorder;
  const RateIndex rate = recorder.add_rate(*Rational::from_text("0.1"), {});
  const StateIn x = add_state(recorder, "x");
  const StateIn d = add_discrete(recorder, "d", rate);
  const Value fast = sin(x.value);
  recorder.rate = rate;
  const Value doubled = fast * 2.0;
  recorder.rate = 0;
  recorder.record.discretes[d.index].next = doubled;
  const auto program = compiled(recorder, {doubled, fast});
  EXPECT_EQ(program->watch_masks[0], rate_bit(rate));
  EXPECT_EQ(program->watch_masks[1], continuous_bit);
  Evaluation evaluation(program);
  evaluation.set_state(x.index, 1);
  evaluation.settle();
  evaluation.set_state(x.index, 0.5);
  EXPECT_EQ(evaluation.watches()[0], 2 * std::sin(1.0));
  EXPECT_EQ(evaluation.watches()[1], std::sin(0.5));
  execute(program->held_list, evaluation.frame().arena, nullptr, rate_bit(rate));
  EXPECT_EQ(evaluation.watches()[0], 2 * std::sin(0.5));
  EXPECT_EQ(evaluation.frame().arena[program->nexts[0]], 2 * std::sin(0.5));
}

TEST(Masks, TellWhichHeldValuesDerivativesRead) {
  Recorder recorder;
  const RateIndex rate = recorder.add_rate(*Rational::from_text("0.1"), {});
  const StateIn read = add_discrete(recorder, "read", rate), unread = add_discrete(recorder, "unread", rate);
  const StateIn x = add_state(recorder, "x");
  recorder.record.states[x.index].derivative = x.value * sin(read.value);
  recorder.record.discretes[unread.index].next = x.value;
  const auto program = compiled(recorder, {unread.value});
  EXPECT_EQ(program->held_in_derivatives.size(), 1u);
}

TEST(Masks, ASharedFrameIsNotTouchedByACopy) {
  Recorder recorder;
  const StateIn x = add_state(recorder, "x");
  recorder.record.states[x.index].derivative = 2.0 * x.value;
  Evaluation evaluation(compiled(recorder));
  evaluation.set_state(x.index, 3);
  const Frame copy(evaluation.frame());
  evaluation.set_state(x.index, 4);
  EXPECT_EQ(copy.arena[copy.program->states], 3);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(copy.arena) % 64, 0u);
}

}  // namespace
}  // namespace plantloop::testing_programs
