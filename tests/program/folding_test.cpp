// Folding, simplification and sharing change no finite value.

#include <cmath>

#include "tests/program/random_equations.h"

namespace plantloop::testing_programs {
namespace {

TEST(Folding, OfKnownNumbersNeedsNoRecorder) {
  const Value two = 2, three = 3;
  EXPECT_EQ((two * three + 1.0).number(), 7);
  EXPECT_EQ(where(two < three, 5.0, 6.0).number(), 5);
  EXPECT_EQ(mod(Value(-1), Value(3)).number(), 2);
  EXPECT_EQ(sum(Array::vector({1, 2, 3, 4, 5})).number(), 15);
  EXPECT_EQ(sum(std::span<const Value>{}).number(), 0);
}

TEST(Folding, MakesNoOperationOfANeutralElement) {
  Recorder recorder;
  const Value x = recorder.parameter("x", 3);
  const std::size_t before = recorder.record.nodes.size();
  for (const Value& v : {x + 0.0, 0.0 + x, x - 0.0, x * 1.0, 1.0 * x, x / 1.0, pow(x, Value(1))}) {
    EXPECT_EQ(v.id(), x.id());
  }
  EXPECT_TRUE((x * 0.0).is(0));
  EXPECT_TRUE((0.0 * x).is(0));
  EXPECT_TRUE((0.0 / x).is(0));
  EXPECT_TRUE(pow(x, Value(0)).is(1));
  EXPECT_EQ(where(Truth(1), x, Value(7)).id(), x.id());
  EXPECT_EQ(where(Truth(0), Value(7), x).id(), x.id());
  EXPECT_EQ(recorder.record.nodes.size(), before);
}

TEST(Folding, KeepsADifferenceOfEqualValuesSinceThatIsHowANaNShows) {
  Recorder recorder;
  const Value x = recorder.parameter("x", INFINITY);
  Evaluation evaluation(compiled(recorder, {x - x, x / x}));
  evaluation.settle();
  for (const double v : evaluation.watches()) EXPECT_TRUE(std::isnan(v));
}

TEST(Folding, IsExactForFiniteValuesInRandomEquations) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    std::mt19937 random(seed);
    Recorder recorder;
    const RandomEquations made = random_equations(recorder, random, {.layers = 40, .width = 3});
    Evaluation evaluation(compiled(recorder, made.values));
    set_leaves(evaluation);
    evaluation.settle();
    const std::vector<double> values = evaluation.watches();
    int compared = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!made.clean[i]) continue;
      ++compared;
      EXPECT_EQ(values[i], made.numbers[i]) << "value " << i << " of seed " << seed;  // 0 equals -0
    }
    EXPECT_GT(compared, 40);
  }
}

TEST(Sharing, EqualOperationsAreOneAndSoAreCommutedTwins) {
  Recorder recorder;
  const Value x = recorder.parameter("x", 3), y = recorder.parameter("y", 4);
  const auto program = compiled(recorder, {x * y, y * x, x + y, y + x, sin(x * y), sin(y * x), x - y, y - x});
  const auto& watches = program->resolved->watches;
  EXPECT_EQ(watches[0], watches[1]);
  EXPECT_EQ(watches[2], watches[3]);
  EXPECT_EQ(watches[4], watches[5]);
  EXPECT_NE(watches[6], watches[7]);
}

TEST(Sharing, DoesNotMixOperationsOfDifferentRates) {
  Recorder recorder;
  const RateIndex fast = recorder.add_rate(*Rational::from_text("0.1"), {});
  const RateIndex slow = recorder.add_rate(*Rational::from_text("0.2"), {});
  const StateIn x = add_state(recorder, "x");
  const auto sampled = [&](RateIndex rate) {
    recorder.rate = rate;
    const Value v = recorder.operation(Op::copy, x.value, 0, 0);
    recorder.rate = 0;
    return v;
  };
  const Value a = sampled(fast), b = sampled(slow), again = sampled(fast);
  const auto program = compiled(recorder, {a, b, again});
  EXPECT_NE(program->resolved->watches[0], program->resolved->watches[1]);
  EXPECT_EQ(program->resolved->watches[0], program->resolved->watches[2]);
}

TEST(Sums, AreRecordedByHalvingAndSoRunInADefinedOrder) {
  Recorder recorder;
  std::vector<Value> values;
  std::vector<double> numbers;
  for (int i = 0; i < 37; ++i) {
    numbers.push_back(std::pow(-1.7, i));
    values.push_back(recorder.parameter("p", numbers.back()));
  }
  Evaluation evaluation(compiled(recorder, {sum(values)}));
  evaluation.settle();
  while (numbers.size() > 1) {
    const std::size_t half = (numbers.size() + 1) / 2;
    for (std::size_t i = 0; i + half < numbers.size(); ++i) numbers[i] += numbers[i + half];
    numbers.resize(half);
  }
  EXPECT_EQ(evaluation.watches().front(), numbers.front());
}

TEST(Matrices, MultiplyInEveryShape) {
  const Matrix a = Matrix::matrix(2, 3, {1, 2, 3, 4, 5, 6});
  const Matrix b = Matrix::matrix(3, 2, {7, 8, 9, 10, 11, 12});
  const Matrix product = mul(a, b);
  EXPECT_EQ(product(0, 0).number(), 58);
  EXPECT_EQ(product(1, 1).number(), 154);
  const Vector column = mul(a, Vector::vector({1, 0, -1}));
  EXPECT_EQ(column.shape(), Shape::vector(2));
  EXPECT_EQ(column[1].number(), -2);
  const Vector row = mul(Vector::vector({1, -1}), a);
  EXPECT_EQ(row.shape(), Shape::vector(3));
  EXPECT_EQ(row[2].number(), -3);
  EXPECT_EQ(transpose(a)(2, 1).number(), 6);
}

TEST(Picking, ClipsTheIndexAtBothEnds) {
  const Array values = Array::vector({10, 20, 30, 40, 50});
  EXPECT_EQ(pick(values, Value(-3)).number(), 10);
  EXPECT_EQ(pick(values, Value(2)).number(), 30);
  EXPECT_EQ(pick(values, Value(99)).number(), 50);
}

}  // namespace
}  // namespace plantloop::testing_programs
