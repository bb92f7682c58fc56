// Wires in any order; algebraic loops and initial values that depend on each other, each with its closed path.

#include <gmock/gmock.h>

#include <cmath>

#include "tests/program/programs.h"

namespace plantloop::testing_programs {
namespace {

using ::testing::HasSubstr;

// Operations from now on are those of this block.
void in_block(Recorder& recorder, const std::string& path) { recorder.site = recorder.add_site(path, "outputs", {}); }

int lines(const std::string& text) { return static_cast<int>(std::count(text.begin(), text.end(), '\n')); }

TEST(Wires, MayBeReadBeforeTheirDriverIsRecorded) {
  Recorder recorder;
  const Value a = recorder.wire(), b = recorder.wire(), c = recorder.wire();
  const Value result = a + b * c;
  recorder.bind(c, a * 2.0);
  recorder.bind(b, recorder.parameter("p", 3));
  recorder.bind(a, b + 1.0);
  Evaluation evaluation(compiled(recorder, {result, c}));
  evaluation.settle();
  EXPECT_EQ(evaluation.watches()[0], 4 + 3 * 8);
  EXPECT_EQ(evaluation.watches()[1], 8);
}

TEST(Wires, OfAVeryLongChainAreFollowedWithoutRecursion) {
  Recorder recorder;
  constexpr int n = 200'000;
  std::vector<Value> wires;
  for (int i = 0; i < n; ++i) wires.push_back(recorder.wire());
  for (int i = 0; i + 1 < n; ++i)
    recorder.bind(wires[static_cast<std::size_t>(i)], wires[static_cast<std::size_t>(i) + 1] + 1.0);
  recorder.bind(wires.back(), recorder.parameter("p", 1));
  Evaluation evaluation(compiled(recorder, {wires.front()}));
  evaluation.settle();
  EXPECT_EQ(evaluation.watches()[0], n);
}

TEST(Loops, AreReportedWithTheClosedPathOfBlocks) {
  Recorder recorder;
  const Value back = recorder.wire();
  in_block(recorder, "gain");
  const Value gain = 2.0 * back;
  in_block(recorder, "sum");
  const Value sum = gain + 1.0;
  recorder.bind(back, sum);
  recorder.record.signals.push_back({"sum", sum, {}, 0});
  const std::string text = findings_of(recorder);
  EXPECT_EQ(lines(text), 1) << text;
  EXPECT_THAT(text, HasSubstr("algebraic loop: gain -> sum -> gain"));
}

TEST(Loops, ThatAreIndependentGiveOneFindingEach) {
  Recorder recorder;
  for (const char* name : {"first", "second"}) {
    const Value back = recorder.wire();
    in_block(recorder, name);
    const Value v = sin(back);
    recorder.bind(back, v);
    recorder.record.signals.push_back({name, v, {}, 0});
  }
  const std::string text = findings_of(recorder);
  EXPECT_EQ(lines(text), 2) << text;
  EXPECT_THAT(text, HasSubstr("first -> first"));
  EXPECT_THAT(text, HasSubstr("second -> second"));
}

TEST(Loops, AreNotSeenWhereATwoChannelBlockCrossesItsChannels) {
  // y1 = u1, y2 = u2 + 1, and u2 = y1: no signal depends on itself.
  Recorder recorder;
  const Value u1 = recorder.wire(), u2 = recorder.wire();
  in_block(recorder, "channels");
  const Value y1 = 2.0 * u1, y2 = u2 + 1.0;
  recorder.bind(u2, y1);
  recorder.bind(u1, recorder.parameter("p", 5));
  Evaluation evaluation(compiled(recorder, {y2}));
  evaluation.settle();
  EXPECT_EQ(evaluation.watches()[0], 11);
}

TEST(Loops, AreBrokenByAState) {
  Recorder recorder;
  const StateIn x = add_state(recorder, "x");
  recorder.record.states[x.index].derivative = -x.value;
  EXPECT_EQ(findings_of(recorder), "");
}

TEST(Loops, ThroughAnEntryThatIsZeroAreNone) {
  Recorder recorder;
  const Value back = recorder.wire();
  in_block(recorder, "matrix");
  const Value y = Value(0) * back + recorder.parameter("p", 1);
  recorder.bind(back, y);
  recorder.record.signals.push_back({"y", y, {}, 0});
  EXPECT_EQ(findings_of(recorder), "");
}

// The equations of a pair of loops that share z: x = sin(z) + p, z = 0.5 x + 0.25 y, y = z^2 - s.
struct SharedLoops {
  Recorder recorder;
  StateIn s;
  Value x, y, z;
  SharedLoops() : s(add_state(recorder, "s", 0.3)) {
    const Value back = recorder.wire();
    in_block(recorder, "x");
    x = sin(back) + recorder.parameter("p", 1);
    in_block(recorder, "y");
    y = back * back - s.value;
    in_block(recorder, "z");
    z = 0.5 * x + 0.25 * y;
    recorder.bind(back, z);
    recorder.record.signals.push_back({"x", x, {}, 0});
    recorder.record.signals.push_back({"y", y, {}, 0});
    recorder.record.signals.push_back({"z", z, {}, 0});
    recorder.record.states[s.index].derivative = x * y - s.value;
  }
};

TEST(Loops, ThatShareASignalAreCutThere) {
  SharedLoops loops;
  const auto program = compiled(loops.recorder, {loops.x, loops.y, loops.z});
  ASSERT_EQ(program->loops.size(), 1u);
  EXPECT_EQ(program->loops[0].names, std::vector<std::string>{"z"});
}

TEST(Loops, AreSolvedWhereverTheyAreRead) {
  SharedLoops loops;
  Evaluation evaluation(compiled(loops.recorder, {loops.x, loops.y, loops.z}));
  evaluation.settle();
  for (const double s : {-0.5, 0.0, 0.7}) {
    evaluation.set_state(loops.s.index, s);
    const auto values = evaluation.watches();
    EXPECT_NEAR(values[0], std::sin(values[2]) + 1, 1e-15);
    EXPECT_NEAR(values[1], values[2] * values[2] - s, 1e-15);
    EXPECT_NEAR(values[2], 0.5 * values[0] + 0.25 * values[1], 1e-15);
    EXPECT_NEAR(evaluation.derivatives()[0], values[0] * values[1] - s, 1e-15);
  }
}

TEST(Loops, AreDifferentiatedThroughTheirEquations) {
  SharedLoops one;
  // Two unknowns: x = s - cos(y), y = 0.4 x y + s.
  Recorder two;
  const StateIn s = add_state(two, "s", 0.3);
  const Value x = two.wire(), y = two.wire();
  in_block(two, "x");
  const Value gives_x = s.value - cos(y) + 0.2 * x;
  in_block(two, "y");
  const Value gives_y = 0.4 * x * y + s.value - 0.1 * y * y;
  two.bind(x, gives_x);
  two.bind(y, gives_y);
  two.record.states[s.index].derivative = gives_x * gives_y;
  EXPECT_EQ(compiled(two)->loops.front().size(), 2u);
  for (const Recorder* recorder : {&one.recorder, &two}) {
    Evaluation evaluation(compiled(*recorder));
    evaluation.settle();
    constexpr double h = 1e-5;
    evaluation.set_state(0, 0.3 - h);
    const double before = evaluation.derivatives()[0];
    evaluation.set_state(0, 0.3 + h);
    const double after = evaluation.derivatives()[0];
    evaluation.set_state(0, 0.3);
    EXPECT_NEAR(evaluation.jacobian()[0][0], (after - before) / (2 * h), 1e-8);  // error of the difference: h^2
  }
}

TEST(Loops, LeaveNothingBehindWhereThereAreNone) {
  Recorder recorder;
  const StateIn x = add_state(recorder, "x");
  recorder.record.states[x.index].derivative = -x.value;
  const auto program = compiled(recorder);
  EXPECT_TRUE(program->loops.empty());
  EXPECT_TRUE(program->loop_list.empty());
}

TEST(InitialValues, MayReadSignalsAndOtherStatesInAnyOrder) {
  Recorder recorder;
  const Value later = recorder.wire();
  const StateIn x = add_state(recorder, "x", later * 2.0);
  const StateIn y = add_state(recorder, "y", 3);
  const Value signal = y.value * y.value + recorder.parameter("p", 1);
  recorder.bind(later, signal);
  recorder.record.states[x.index].derivative = -x.value;
  recorder.record.states[y.index].derivative = x.value;
  const auto program = compiled(recorder, {x.value, y.value});
  Frame frame(program);
  execute(program->parameter_list, frame.arena);
  execute(program->initial_list, frame.arena);
  EXPECT_EQ(frame.arena[program->initial_list.roots[program->place_of_state[x.index]]], 20);
  EXPECT_EQ(frame.arena[program->initial_list.roots[program->place_of_state[y.index]]], 3);
}

TEST(InitialValues, ThatDependOnEachOtherAreReportedWithTheirPath) {
  Recorder recorder;
  in_block(recorder, "tank");
  const StateIn x = add_state(recorder, "tank");
  in_block(recorder, "pump");
  const StateIn y = add_state(recorder, "pump", x.value + 1.0);
  recorder.record.states[x.index].initial = y.value;
  const std::string text = findings_of(recorder);
  EXPECT_EQ(lines(text), 1) << text;
  EXPECT_THAT(text, HasSubstr("initial values depend on each other: pump -> tank -> pump"));
}

}  // namespace
}  // namespace plantloop::testing_programs
