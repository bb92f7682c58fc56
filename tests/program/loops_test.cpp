// Wires in any order; algebraic loops and initial values that depend on each other, each with its closed path.

#include <gmock/gmock.h>

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
