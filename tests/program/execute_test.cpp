// The executors give the same bits, whatever runs wide, narrow, fused or by the switch.

#include <algorithm>
#include <numeric>

#include "engine/program/lower.h"
#include "tests/program/random_equations.h"

namespace plantloop::testing_programs {
namespace {

// All equations in one list over an arena of its own.
std::vector<double> run_once(const Resolved& resolved, const Program& program, bool fuse, bool by_switch,
                             std::size_t every) {
  Lowering lowering(resolved.graph, resolved.activations);
  Lowering::Request request;
  request.parameter_only_is_external = false;
  request.held_is_external = false;
  request.fuse = fuse;
  for (std::size_t i = 0; i < resolved.watches.size(); i += every) request.roots.push_back(resolved.watches[i]);
  const List list = lowering.lower(request);
  std::vector<std::pair<std::uint32_t, double>> leaves;
  Evaluation values{std::shared_ptr<const Program>(&program, [](const Program*) {})};
  set_leaves(values);
  values.settle();
  for (std::uint32_t id = 0; id < resolved.graph.operations.size(); ++id) {
    const Operation& o = resolved.graph.operations[id];
    if (!is_leaf(o.op) || !lowering.has_slot(id)) continue;
    double number = 0;
    double* const arena = values.frame().arena;
    if (o.op == Op::constant) number = resolved.graph.constant(id);
    if (o.op == Op::parameter) number = arena[program.parameters[o.a]];
    if (o.op == Op::state) number = values.frame().states()[program.place_of_state[o.a]];
    if (o.op == Op::discrete) number = arena[program.discretes[o.a]];
    if (o.op == Op::mode) number = arena[program.modes[o.a]];
    if (o.op == Op::time) number = arena[program.time];
    leaves.emplace_back(lowering.slot(id), number);
  }
  std::vector<double> arena(lowering.size() + 8, 0.0);
  for (const auto& [slot, number] : leaves) arena[slot] = number;
  if (by_switch) {
    execute_by_switch(list, arena.data());
  } else {
    execute(list, arena.data());
  }
  std::vector<double> result;
  for (const auto slot : list.roots) result.push_back(arena[slot]);
  return result;
}

void expect_same(const std::vector<double>& a, const std::vector<double>& b, unsigned seed, const char* what) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_TRUE(same_bits(a[i], b[i])) << what << ", value " << i << " of seed " << seed << ": " << a[i] << ", "
                                       << b[i];
  }
}

void compare_executors(const RandomShape& shape, unsigned first_seed, unsigned seeds) {
  for (unsigned seed = first_seed; seed < first_seed + seeds; ++seed) {
    std::mt19937 random(seed);
    Recorder recorder;
    const RandomEquations made = random_equations(recorder, random, shape);
    const auto program = compiled(recorder, made.values);
    for (const std::size_t every : {std::size_t{1}, std::size_t{17}}) {
      const std::vector<double> reference = run_once(*program->resolved, *program, false, true, every);
      expect_same(reference, run_once(*program->resolved, *program, false, false, every), seed, "grouped");
      expect_same(reference, run_once(*program->resolved, *program, true, true, every), seed, "fused by switch");
      expect_same(reference, run_once(*program->resolved, *program, true, false, every), seed, "fused and grouped");
    }
    Evaluation evaluation(program);
    set_leaves(evaluation);
    evaluation.settle();
    expect_same(run_once(*program->resolved, *program, false, true, 1), evaluation.watches(), seed, "whole program");
  }
}

TEST(Executors, AgreeOnNarrowEquations) { compare_executors({.layers = 60, .width = 2}, 100, 25); }
TEST(Executors, AgreeOnLooseSheets) { compare_executors({.layers = 12, .width = 40}, 200, 20); }
TEST(Executors, AgreeOnRegularSheets) { compare_executors({.layers = 25, .width = 37, .regular = true}, 300, 25); }
TEST(Executors, AgreeWhereWideAndNarrowMix) { compare_executors({.layers = 60, .width = 7, .regular = true}, 400, 20); }

TEST(Executors, AgreeOnEveryOperationInEveryPattern) {
  // Each operation over operands that are contiguous, constant or gathered: all loops of the table.
  for (const Op op : all_operations()) {
    for (int pattern = 0; pattern < 27; ++pattern) {
      Recorder recorder;
      std::vector<Value> pool;
      std::vector<double> numbers;
      std::mt19937 random(7);
      std::uniform_real_distribution<double> uniform(-3, 3);
      for (int i = 0; i < 90; ++i) {
        numbers.push_back(uniform(random));
        pool.push_back(add_state(recorder, "x" + std::to_string(1000 + i)).value);
      }
      recorder.plain = true;  // no modes: the operation itself
      std::vector<Value> values;
      std::vector<double> expected;
      for (int i = 0; i < 30; ++i) {
        std::size_t operands[3];
        int rest = pattern;
        for (int k = 0; k < 3; ++k, rest /= 3) {
          const int way = rest % 3;
          operands[k] = static_cast<std::size_t>(30 * k + (way == 0 ? i : way == 1 ? 0 : (i * 7) % 30));
        }
        values.push_back(plantloop::record(op, pool[operands[0]], pool[operands[1]], pool[operands[2]]));
        expected.push_back(apply(op, numbers[operands[0]], numbers[operands[1]], numbers[operands[2]]));
      }
      Evaluation evaluation(compiled(recorder, values));
      for (std::uint32_t i = 0; i < numbers.size(); ++i) evaluation.set_state(i, numbers[i]);
      evaluation.settle();
      const std::vector<double> found = evaluation.watches();
      for (std::size_t i = 0; i < found.size(); ++i) {
        ASSERT_TRUE(same_bits(found[i], expected[i])) << name_of(op) << " in pattern " << pattern;
      }
    }
  }
}

TEST(Executors, RunAHundredThousandOperationsInARow) {
  // A chain one wide: as deep as recursion could go.
  Recorder recorder;
  const StateIn x = add_state(recorder, "x");
  Value v = x.value;
  double expected = 0.5;
  for (int i = 0; i < 100'000; ++i) {
    v = i % 2 == 0 ? v * 1.0000001 : sin(v);
    expected = i % 2 == 0 ? expected * 1.0000001 : std::sin(expected);
  }
  recorder.record.states[x.index].derivative = v;
  Evaluation evaluation(compiled(recorder, {v}));
  evaluation.set_state(x.index, 0.5);
  evaluation.settle();
  EXPECT_EQ(evaluation.watches().front(), expected);
  EXPECT_EQ(evaluation.derivatives().front(), expected);
  const List& list = evaluation.frame().program->watch_list;
  execute_by_switch(list, evaluation.frame().arena);
  EXPECT_EQ(evaluation.frame().arena[list.roots.front()], expected);
}

TEST(Executors, FuseAProductIntoASumWithBothRoundings) {
  // With a fused multiply-add the result would be -2^-60: the product's rounding would be missing.
  Recorder recorder;
  const StateIn a = add_state(recorder, "a"), b = add_state(recorder, "b");
  const double x = 1 + std::ldexp(1, -30);
  recorder.record.states[a.index].derivative = a.value * b.value - (1 + std::ldexp(1, -29));
  Evaluation evaluation(compiled(recorder));
  evaluation.set_state(a.index, x);
  evaluation.set_state(b.index, x);
  evaluation.settle();
  EXPECT_EQ(evaluation.derivatives()[0], x * x - (1 + std::ldexp(1, -29)));
  EXPECT_EQ(evaluation.derivatives()[0], 0);
}

}  // namespace
}  // namespace plantloop::testing_programs
