// Layers of one operation each: what a matrix product, a chain or a loose sheet of equations looks like.

#include "tests/program/random_equations.h"

#include <cmath>

namespace plantloop::testing_programs {

namespace {

constexpr double state_values[] = {0.7, -1.3, 2.1, 0.25};
constexpr double parameter_values[] = {1.5, -0.4, 3.25, 0.1};
constexpr double discrete_values[] = {-0.6, 4.5};
constexpr double time_value = 1.75;

// Powers with these exponents are written as products; each rounds for itself.
double power(double a, double b, bool exponent_is_known) {
  if (exponent_is_known && b == 2) return a * a;
  if (exponent_is_known && b == 3) return a * a * a;
  if (exponent_is_known && b == -1) return 1 / a;
  if (exponent_is_known && b == 0.5) return std::sqrt(a);
  return std::pow(a, b);
}

bool is_smooth(Op op) {
  switch (op) {
    case Op::neg:
    case Op::sin:
    case Op::cos:
    case Op::atan:
    case Op::tanh:
    case Op::asinh:
    case Op::erf:
    case Op::add:
    case Op::sub:
    case Op::mul:
    case Op::hypot:
    case Op::where:
      return true;
    default:
      return false;
  }
}

class Generator {
 public:
  Generator(Recorder& recorder, std::mt19937& random, const RandomShape& shape)
      : recorder_(recorder), random_(random), shape_(shape) {}

  RandomEquations operator()() {
    leaves();
    for (int layer = 0; layer < shape_.layers; ++layer) add_layer();
    return std::move(made_);
  }

 private:
  void put(Value value, double number, bool clean) {
    made_.values.push_back(value);
    made_.numbers.push_back(number);
    made_.clean.push_back(clean && std::isfinite(number));
  }

  void leaves() {
    const RateIndex fast = recorder_.add_rate(*Rational::from_text("0.1"), {});
    const RateIndex slow = recorder_.add_rate(*Rational::from_text("0.3"), {});
    for (int i = 0; i < 4; ++i) put(add_state(recorder_, "x" + std::to_string(i)).value, state_values[i], true);
    for (int i = 0; i < 4; ++i)
      put(recorder_.parameter("p" + std::to_string(i), parameter_values[i]), parameter_values[i], true);
    put(add_discrete(recorder_, "d0", fast).value, discrete_values[0], true);
    put(add_discrete(recorder_, "d1", slow).value, discrete_values[1], true);
    put(recorder_.time(), time_value, true);
    put(Value(1.0), 1.0, true);
  }

  int any(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random_); }

  // An operand: one of the values so far, or a number that folds often.
  std::size_t operand() {
    if (any(8) == 0) {
      constexpr double constants[] = {0, 1, -1, 2, 3, 0.5, -2.5, 7};
      const double number = constants[any(8)];
      put(Value(number), number, true);
      return made_.values.size() - 1;
    }
    return static_cast<std::size_t>(any(static_cast<int>(made_.values.size())));
  }

  void add_layer() {
    static const std::vector<Op> operations = all_operations();
    Op op = operations[static_cast<std::size_t>(any(static_cast<int>(operations.size())))];
    while (shape_.smooth && !is_smooth(op))
      op = operations[static_cast<std::size_t>(any(static_cast<int>(operations.size())))];
    const auto width = static_cast<std::size_t>(shape_.width);
    std::vector<std::array<std::size_t, 3>> chosen;
    const bool from_last = shape_.regular && made_.values.size() >= 2 * width && any(4) != 0;
    const std::size_t start = made_.values.size() - (from_last ? width : 0);
    const std::array<std::size_t, 3> common{operand(), operand(), operand()};
    const int pattern = any(27);
    for (std::size_t i = 0; i < width; ++i) {
      std::array<std::size_t, 3> operands{};
      for (int k = 0; k < 3; ++k) {
        const int way = k == 0 ? pattern % 3 : k == 1 ? pattern / 3 % 3 : pattern / 9;
        operands[static_cast<std::size_t>(k)] = from_last && way == 0   ? start + i
                                                : from_last && way == 1 ? common[static_cast<std::size_t>(k)]
                                                                        : operand();
      }
      chosen.push_back(operands);
    }
    for (const auto& operands : chosen) add_operation(op, operands);
  }

  void add_operation(Op op, const std::array<std::size_t, 3>& o) {
    const int arity = arity_of(op);
    const Value a = made_.values[o[0]];
    const Value b = arity > 1 ? made_.values[o[1]] : Value(0);
    const Value c = arity > 2 ? made_.values[o[2]] : Value(0);
    const double x = made_.numbers[o[0]];
    const double y = arity > 1 ? made_.numbers[o[1]] : 0;
    const double z = arity > 2 ? made_.numbers[o[2]] : 0;
    bool clean = made_.clean[o[0]] && (arity < 2 || made_.clean[o[1]]) && (arity < 3 || made_.clean[o[2]]);
    double number = op == Op::pow ? power(x, y, b.is_known()) : apply(op, x, y, z);
    if (op == Op::atan2 && x == 0) clean = false;
    // A continuous remainder is written with a frozen quotient: a - b floor(a / b).
    if (op == Op::mod) clean = false;
    put(plantloop::record(op, a, b, c), number, clean);
  }

  Recorder& recorder_;
  std::mt19937& random_;
  RandomShape shape_;
  RandomEquations made_;
};

}  // namespace

RandomEquations random_equations(Recorder& recorder, std::mt19937& random, const RandomShape& shape) {
  return Generator(recorder, random, shape)();
}

void set_leaves(Evaluation& evaluation) {
  for (std::uint32_t i = 0; i < 4; ++i) evaluation.set_state(i, state_values[i]);
  for (std::uint32_t i = 0; i < 2; ++i) evaluation.set_discrete(i, discrete_values[i]);
  evaluation.set_time(time_value);
}

std::vector<Op> all_operations() {
  return {
#define X(name, expression) Op::name,
      PLANTLOOP_UNARY_OPERATIONS(X) PLANTLOOP_BINARY_OPERATIONS(X)
#undef X
          Op::where};
}

}  // namespace plantloop::testing_programs
