// Kernels among operations: in lists, at hits, in the initial list, in messages.

#include <gmock/gmock.h>

#include "tests/program/programs.h"

namespace plantloop::testing_programs {
namespace {

// out = (a + b, a b, number of calls of advance); remembers what advance saw.
struct Pair final : Kernel {
  std::string name() const override { return "pair"; }
  int outputs() const override { return 3; }
  int state_size() const override { return 1; }
  void initialise(const KernelCall& call) const override { call.state[0] = call.in[0]; }
  void evaluate(const KernelCall& call) const override {
    call.out[0] = call.in[0] + call.in[1];
    call.out[1] = call.in[0] * call.in[1];
    call.out[2] = call.state[0];
  }
  void advance(const KernelCall& call) const override { call.state[0] = call.in[0]; }
};

std::vector<Value> use(Recorder& recorder, Value a, Value b, Value advance) {
  KernelUse kernel;
  kernel.kernel = std::make_shared<Pair>();
  kernel.inputs = {recorder.id_of(a), recorder.id_of(b)};
  kernel.advance_inputs = {recorder.id_of(advance)};
  return recorder.kernel(std::move(kernel));
}

TEST(Kernels, StandAmongOperationsOfAnyList) {
  Recorder recorder;
  const StateIn x = add_state(recorder, "x");
  const auto out = use(recorder, sin(x.value), Value(3), x.value);
  recorder.record.states[x.index].derivative = out[0] * out[1];
  const auto program = compiled(recorder, {out[0], out[1], out[0] + 1.0});
  Evaluation evaluation(program);
  evaluation.set_state(x.index, 1);
  evaluation.settle();
  const double s = std::sin(1.0);
  EXPECT_EQ(evaluation.watches(), (std::vector<double>{s + 3, s * 3, s + 3 + 1.0}));
  EXPECT_EQ(evaluation.derivatives()[0], (s + 3) * (s * 3));
  EXPECT_FALSE(program->jacobian_is_exact);
}

TEST(Kernels, OfADiscreteBlockRunAtItsHits) {
  Recorder recorder;
  const RateIndex rate = recorder.add_rate(*Rational::from_text("0.1"), {});
  const StateIn x = add_state(recorder, "x");
  recorder.rate = rate;
  const auto out = use(recorder, x.value, Value(2), x.value);
  const Value doubled = out[0] * 2.0;
  recorder.rate = 0;
  recorder.record.states[x.index].derivative = out[1];
  const auto program = compiled(recorder, {out[0], doubled});
  EXPECT_EQ(program->kernels[0].mask, rate_bit(rate));
  EXPECT_TRUE(program->jacobian_is_exact);  // held: no derivative depends on the state through it
  Evaluation evaluation(program);
  evaluation.set_state(x.index, 5);
  evaluation.settle();
  evaluation.set_state(x.index, 6);
  EXPECT_EQ(evaluation.watches(), (std::vector<double>{7, 14}));
  EXPECT_EQ(evaluation.derivatives()[0], 10);
  KernelFrame kernels = evaluation.frame().kernel_frame(false);
  execute(program->held_list, evaluation.frame().arena, &kernels, rate_bit(rate));
  EXPECT_EQ(evaluation.watches(), (std::vector<double>{8, 16}));
}

TEST(Kernels, StartInTheInitialListInOrder) {
  // The first kernel starts with the initial value of x, the second with an output of the first.
  Recorder recorder;
  const StateIn x = add_state(recorder, "x", recorder.parameter("p", 4));
  const Value wire = recorder.wire();
  const auto second = use(recorder, Value(1), Value(1), wire);
  const auto first = use(recorder, Value(10), Value(20), x.value);
  recorder.bind(wire, first[2] + first[0]);
  const StateIn y = add_state(recorder, "y", second[2] * 2.0);
  const auto program = compiled(recorder, {second[2], first[2]});
  Frame frame(program);
  KernelFrame kernels = frame.kernel_frame(false);
  execute(program->parameter_list, frame.arena, &kernels);
  execute(program->initial_list, frame.arena, &kernels);
  EXPECT_EQ(frame.kernel_states[program->kernels[1].first_state], 4);
  EXPECT_EQ(frame.kernel_states[program->kernels[0].first_state], 34);
  EXPECT_EQ(frame.arena[program->initial_list.roots[program->place_of_state[y.index]]], 68);
}

TEST(Kernels, WithoutDerivativeAreNamed) {
  Recorder recorder;
  recorder.site = recorder.add_site("table", "outputs", {});
  const StateIn x = add_state(recorder, "x");
  const auto out = use(recorder, x.value, Value(2), Value(0));
  recorder.record.states[x.index].derivative = out[1];
  EXPECT_THAT(compiled(recorder)->differenced, ::testing::ElementsAre("table"));
}

TEST(Kernels, MayReadTheirOwnPastInALoop) {
  // Only `advance` reads the loop's signal: no algebraic loop.
  Recorder recorder;
  recorder.site = recorder.add_site("memory", "outputs", {});
  const Value back = recorder.wire();
  KernelUse kernel;
  struct Memory final : Kernel {
    std::string name() const override { return "memory"; }
    int outputs() const override { return 1; }
    int state_size() const override { return 1; }
    bool starts_with_inputs() const override { return false; }
    void evaluate(const KernelCall& call) const override { call.out[0] = call.state[0]; }
    void advance(const KernelCall& call) const override { call.state[0] = call.in[0]; }
  };
  kernel.kernel = std::make_shared<Memory>();
  kernel.advance_inputs = {back.id()};
  const Value y = recorder.kernel(std::move(kernel))[0] + 1.0;
  recorder.bind(back, y);
  recorder.record.signals.push_back({"y", y, {}, 0});
  EXPECT_EQ(findings_of(recorder), "");
}

}  // namespace
}  // namespace plantloop::testing_programs
