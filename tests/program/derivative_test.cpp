// Exact derivatives against closed forms and differences.

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "tests/program/random_equations.h"

namespace plantloop::testing_programs {
namespace {

// x' = f(x): df/dx at x.
double derivative_at(const std::function<Value(Value)>& f, double x) {
  Recorder recorder;
  const StateIn state = add_state(recorder, "x");
  recorder.record.states[state.index].derivative = f(state.value);
  Evaluation evaluation(compiled(recorder));
  evaluation.set_state(state.index, x);
  evaluation.settle();
  return evaluation.jacobian()[0][0];
}

struct Known {
  const char* name;
  std::function<Value(Value)> f;
  std::function<double(double)> derivative;
  std::vector<double> at;
};

std::vector<Known> known_derivatives() {
  using std::cosh;
  return {
      {"neg", [](Value x) { return -x; }, [](double) { return -1; }, {0.3}},
      {"abs", [](Value x) { return abs(x); }, [](double x) { return x < 0 ? -1 : 1; }, {0.3, -0.3}},
      {"sqrt", [](Value x) { return sqrt(x); }, [](double x) { return 0.5 / std::sqrt(x); }, {0.3, 4}},
      {"cbrt",
       [](Value x) { return cbrt(x); },
       [](double x) { return 1 / (3 * std::cbrt(x) * std::cbrt(x)); },
       {0.3, -4}},
      {"exp", [](Value x) { return exp(x); }, [](double x) { return std::exp(x); }, {0.3, -2}},
      {"log", [](Value x) { return log(x); }, [](double x) { return 1 / x; }, {0.3, 5}},
      {"log2", [](Value x) { return log2(x); }, [](double x) { return 1 / (x * std::log(2.0)); }, {0.3, 5}},
      {"log10", [](Value x) { return log10(x); }, [](double x) { return 1 / (x * std::log(10.0)); }, {0.3, 5}},
      {"sin", [](Value x) { return sin(x); }, [](double x) { return std::cos(x); }, {0.3, 5}},
      {"cos", [](Value x) { return cos(x); }, [](double x) { return -std::sin(x); }, {0.3, 5}},
      {"tan", [](Value x) { return tan(x); }, [](double x) { return 1 / (std::cos(x) * std::cos(x)); }, {0.3, 1.2}},
      {"asin", [](Value x) { return asin(x); }, [](double x) { return 1 / std::sqrt(1 - x * x); }, {0.3, -0.9}},
      {"acos", [](Value x) { return acos(x); }, [](double x) { return -1 / std::sqrt(1 - x * x); }, {0.3, -0.9}},
      {"atan", [](Value x) { return atan(x); }, [](double x) { return 1 / (1 + x * x); }, {0.3, -9}},
      {"sinh", [](Value x) { return sinh(x); }, [](double x) { return std::cosh(x); }, {0.3, -2}},
      {"cosh", [](Value x) { return plantloop::cosh(x); }, [](double x) { return std::sinh(x); }, {0.3, -2}},
      {"tanh", [](Value x) { return tanh(x); }, [](double x) { return 1 / (std::cosh(x) * std::cosh(x)); }, {0.3, -2}},
      {"asinh", [](Value x) { return asinh(x); }, [](double x) { return 1 / std::sqrt(x * x + 1); }, {0.3, -2}},
      {"acosh", [](Value x) { return acosh(x); }, [](double x) { return 1 / std::sqrt(x * x - 1); }, {1.3, 4}},
      {"atanh", [](Value x) { return atanh(x); }, [](double x) { return 1 / (1 - x * x); }, {0.3, -0.9}},
      {"erf",
       [](Value x) { return erf(x); },
       [](double x) { return 2 / std::sqrt(M_PI) * std::exp(-x * x); },
       {0.3, -2}},
      {"floor", [](Value x) { return floor(x); }, [](double) { return 0; }, {0.3, -2.5}},
      {"ceil", [](Value x) { return ceil(x); }, [](double) { return 0; }, {0.3, -2.5}},
      {"round", [](Value x) { return round(x); }, [](double) { return 0; }, {0.3, -2.4}},
      {"trunc", [](Value x) { return trunc(x); }, [](double) { return 0; }, {0.3, -2.5}},
      {"sign", [](Value x) { return sign(x); }, [](double) { return 0; }, {0.3, -2.5}},
      {"square", [](Value x) { return pow(x, Value(2)); }, [](double x) { return 2 * x; }, {0.3, -2.5, 0}},
      {"cube", [](Value x) { return pow(x, Value(3)); }, [](double x) { return 3 * x * x; }, {0.3, -2.5, 0}},
      {"power", [](Value x) { return pow(x, Value(2.7)); }, [](double x) { return 2.7 * std::pow(x, 1.7); }, {0.3, 2}},
      {"exponential",
       [](Value x) { return pow(Value(1.5), x); },
       [](double x) { return std::log(1.5) * std::pow(1.5, x); },
       {0.3, -2}},
      {"both",
       [](Value x) { return pow(x, x); },
       [](double x) { return (std::log(x) + 1) * std::pow(x, x); },
       {0.3, 2}},
      {"over", [](Value x) { return 3.0 / x; }, [](double x) { return -3 / (x * x); }, {0.3, -2}},
      {"quotient",
       [](Value x) { return x / (1.0 + x * x); },
       [](double x) { return (1 - x * x) / ((1 + x * x) * (1 + x * x)); },
       {0.3, -2}},
      {"atan2 of y", [](Value x) { return atan2(x, Value(2)); }, [](double x) { return 2 / (x * x + 4); }, {0.3, -2}},
      {"atan2 of x", [](Value x) { return atan2(Value(2), x); }, [](double x) { return -2 / (x * x + 4); }, {0.3, -2}},
      {"hypot",
       [](Value x) { return hypot(x, Value(2)); },
       [](double x) { return x / std::sqrt(x * x + 4); },
       {0.3, -2}},
      {"mod of a", [](Value x) { return mod(x, Value(2)); }, [](double) { return 1; }, {0.3, -2.5}},
      {"mod of b", [](Value x) { return mod(Value(7), x); }, [](double x) { return -std::floor(7 / x); }, {2.3, -3.1}},
      {"min",
       [](Value x) { return min(x * x, 2.0 * x); },
       [](double x) { return x * x < 2 * x ? 2 * x : 2; },
       {0.3, 3}},
      {"max",
       [](Value x) { return max(x * x, 2.0 * x); },
       [](double x) { return x * x > 2 * x ? 2 * x : 2; },
       {0.3, 3}},
      {"where",
       [](Value x) { return where(x > 1.0, x * x, sin(x)); },
       [](double x) { return x > 1 ? 2 * x : std::cos(x); },
       {0.3, 3}},
      {"used twice",
       [](Value x) { return sin(x) * exp(sin(x)); },
       [](double x) { return std::cos(x) * std::exp(std::sin(x)) * (1 + std::sin(x)); },
       {0.3, 3}},
  };
}

TEST(Derivatives, OfEveryOperationAreExact) {
  for (const Known& known : known_derivatives()) {
    for (const double x : known.at) {
      const double expected = known.derivative(x);
      // A few roundings of numbers of this size.
      EXPECT_NEAR(derivative_at(known.f, x), expected, 1e-14 * (1 + std::fabs(expected))) << known.name << " at " << x;
    }
  }
}

TEST(Derivatives, OfTheRootsAtKinksAreThoseOfTheActiveSide) {
  for (const bool plain : {false, true}) {
    Recorder recorder;
    recorder.plain = plain;  // `zero_crossing: off` must not change them
    const StateIn x = add_state(recorder, "x");
    recorder.record.states[x.index].derivative = abs(x.value) + min(x.value, Value(2)) + max(x.value, Value(-1));
    Evaluation evaluation(compiled(recorder));
    for (const auto& [at, expected] : {std::pair{0.5, 3.0}, {-0.5, 1.0}, {-3.0, 0.0}, {3.0, 2.0}}) {
      evaluation.set_state(x.index, at);
      evaluation.settle();
      EXPECT_EQ(evaluation.jacobian()[0][0], expected) << at;
    }
  }
}

// The side of a `where` that is not taken may be infinite or not a number: nothing of it may reach a derivative.
TEST(Derivatives, StayFiniteWhenTheSideNotTakenIsNot) {
  const auto at = [](const std::function<Value(Value)>& f, double x) { return derivative_at(f, x); };
  const auto root = [](Value x) { return where(x > 0.0, sqrt(x), Value(0)); };
  EXPECT_EQ(at(root, 0), 0);
  EXPECT_EQ(at(root, -1), 0);
  EXPECT_EQ(at(root, 4), 0.25);
  const auto scaled = [](Value x) { return 3.0 * where(x > 0.0, 2.0 * sqrt(x) + 1.0, -x); };
  EXPECT_EQ(at(scaled, 0), -3);
  EXPECT_EQ(at(scaled, 4), 1.5);
  // The side is used twice, under one condition and under two.
  const auto twice = [](Value x) {
    const Value s = sqrt(x);
    return where(x > 0.0, s, Value(0)) + where(x > 0.0, 2.0 * s, x);
  };
  EXPECT_EQ(at(twice, 0), 1);
  EXPECT_EQ(at(twice, 4), 0.75);
  const auto conditions = [](Value x) {
    const Value s = sqrt(x);
    return where(x > 0.0, s, Value(0)) + where(x > 1.0, 2.0 * s, x) + where(x < -1.0, Value(0), x);
  };
  EXPECT_EQ(at(conditions, 0), 2);
  EXPECT_EQ(at(conditions, 4), 0.25 * 3 + 1);
  // Conditions inside conditions, below operations that are shared.
  const auto nested = [](Value x) {
    const Value l = log(x), both = l * sqrt(x);
    return where(x > 0.0, where(x > 1.0, both, l), Value(0)) + where(x > 2.0, both + l, Value(0)) + exp(x);
  };
  EXPECT_EQ(at(nested, 0), 1);
  EXPECT_NEAR(at(nested, 0.5), 2 + std::exp(0.5), 1e-15);
  EXPECT_NEAR(at(nested, 4), 2 * (std::log(4) * 0.25 + 0.5) + 0.25 + std::exp(4), 1e-13);
  // A quotient that is 0/0 on the side not taken, as in sin(x)/x.
  const auto sinc = [](Value x) { return where(abs(x) < 1e-9, 1.0 - x * x / 6.0, sin(x) / x); };
  EXPECT_EQ(at(sinc, 0), 0);
  EXPECT_NEAR(at(sinc, 1), std::cos(1) - std::sin(1), 1e-15);
}

TEST(Derivatives, OfRandomSmoothEquationsAgreeWithDifferences) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    std::mt19937 random(seed);
    Recorder recorder;
    const RandomEquations made = random_equations(recorder, random, {.layers = 15, .width = 3, .smooth = true});
    for (std::size_t i = 0; i < 4; ++i)
      recorder.record.states[i].derivative = tanh(made.values[made.values.size() - 1 - i]);
    Evaluation evaluation(compiled(recorder));
    set_leaves(evaluation);
    evaluation.settle();
    const auto exact = evaluation.jacobian();
    for (std::uint32_t column = 0; column < 4; ++column) {
      const double x = evaluation.frame().states()[evaluation.frame().program->place_of_state[column]];
      const auto f = [&](double d) {
        evaluation.set_state(column, x + d);
        return evaluation.derivatives();
      };
      // Four-point differences: error h^4 f'''''/30 + eps f / h; both about 1e-12 where f is of size 1, and larger
      // where it is steep.
      const double h = 1e-3;
      const auto f1 = f(h), g1 = f(-h), f2 = f(2 * h), g2 = f(-2 * h), f3 = f(h / 2), g3 = f(-h / 2);
      evaluation.set_state(column, x);
      for (std::size_t row = 0; row < 4; ++row) {
        const double wide = (8 * (f1[row] - g1[row]) - (f2[row] - g2[row])) / (12 * h);
        const double narrow = (8 * (f3[row] - g3[row]) - (f1[row] - g1[row])) / (6 * h);
        const double doubt = std::fabs(wide - narrow);  // sixteen times the error of the narrower one
        if (doubt > 1e-4 * (1 + std::fabs(narrow))) continue;
        EXPECT_NEAR(exact[row][column], narrow, 1e-9 * (1 + std::fabs(narrow)) + doubt) << "seed " << seed;
      }
    }
  }
}

TEST(Derivatives, StoreOnlyEntriesThatCanDifferFromZero) {
  Recorder recorder;
  const StateIn x = add_state(recorder, "x"), y = add_state(recorder, "y"), z = add_state(recorder, "z");
  recorder.record.states[x.index].derivative = y.value;
  recorder.record.states[y.index].derivative = -x.value * 2.0;
  recorder.record.states[z.index].derivative = recorder.time() + floor(x.value);
  const auto program = compiled(recorder);
  EXPECT_EQ(program->jacobian_row.size(), 2u);
  EXPECT_TRUE(program->jacobian_is_exact);
}

TEST(Derivatives, DoNotSeeStatesThroughSampledValues) {
  Recorder recorder;
  const RateIndex rate = recorder.add_rate(*Rational::from_text("0.1"), {});
  const StateIn x = add_state(recorder, "x");
  recorder.rate = rate;
  const Value sampled = recorder.operation(Op::copy, x.value, 0, 0), computed = 5.0 * x.value;
  recorder.rate = 0;
  recorder.record.states[x.index].derivative = 3.0 * x.value - sampled * computed;
  Evaluation evaluation(compiled(recorder));
  evaluation.set_state(x.index, 2);
  evaluation.settle();
  EXPECT_EQ(evaluation.jacobian()[0][0], 3);
}

TEST(Derivatives, OfAMatrixOfParametersAreItsEntriesAndNothingIsComputedInASteadyRun) {
  Recorder recorder;
  const int n = 12;
  std::vector<Value> x, a;
  std::mt19937 random(3);
  for (int i = 0; i < n; ++i) x.push_back(add_state(recorder, "x" + std::to_string(100 + i)).value);
  for (int i = 0; i < n * n; ++i)
    a.push_back(recorder.parameter("A." + std::to_string(i), std::uniform_real_distribution<>(-1, 1)(random)));
  const Vector product = mul(Matrix::matrix(n, n, a), Vector::vector(x));
  for (int i = 0; i < n; ++i) recorder.record.states[static_cast<std::size_t>(i)].derivative = product[i];
  const auto program = compiled(recorder);
  EXPECT_EQ(program->jacobian_list.operation_count, 0u);
  Evaluation evaluation(program);
  evaluation.settle();
  const auto jacobian = evaluation.jacobian();
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      EXPECT_EQ(jacobian[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)],
                recorder.record.parameters[static_cast<std::size_t>(i * n + j)].value);
    }
  }
}

}  // namespace
}  // namespace plantloop::testing_programs
