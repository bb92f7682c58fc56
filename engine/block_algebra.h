// What several blocks share: events and conditions, limits on a state or output, and transfer functions in canonical
// form.

#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/block.h"

namespace plantloop {

// Whether the block at hand runs at hits; otherwise it is continuous, and what it remembers changes at events.
inline bool is_sampled(Now now) { return !now.period().is(0); }

// Lets a discrete state of a continuous block follow a value that changes at events only: at each change the state
// takes it. Of a sampled block nothing; its update does that.
void follow(Now now, Jumps jump, const Discrete& state, const Array& value);

// Ends the run where `holds` is 0 at an accepted instant: what a solver tries in between does not count. The message is
// "at time 3 s " and the text, in which {0:g}, {1:g} and {2:g} stand for the numbers.
void insist(Now now, Value holds, const std::string& text, const std::vector<Value>& numbers = {});

// Ends the run where a table's input lies outside its points; `input` names it, as "the input 'u'".
void stay_inside_table(Now now, const std::string& input, Value at, Value least, Value greatest);

// The optional parameters `lower` and `upper` of a block, and what they do.
struct Limits {
  Limits(Block* block, std::string_view lower_doc, std::string_view upper_doc);
  Number lower, upper;

  void check(Checking& checking) const;  // upper greater than lower
  bool given(Now now) const { return now.given(lower) || now.given(upper); }
  // The value, moved to the nearest limit.
  Array clamp(Now now, Array value) const;
  // The rate of a limited state: zero while the state is at a limit and the rate points out of it.
  Array stand_still(Now now, const Array& state, const Array& rate) const;
  // Puts a state on its limit exactly where it reaches it.
  void stop_at_limits(Now now, Jumps jump, const State& state) const;
};

// Every upper[i] must not be less than lower[i] (or, strictly, be greater); a single number spreads.
void check_order(Checking& checking, const Number& lower, const Number& upper, bool strictly);

// num/den in descending powers of s or z, in observable canonical form (K. Ogata, Modern Control Engineering, 9-2).
// With num and den divided by den[0], num filled with zeros in front, and n the degree of den:
//
//   y = x1 + b0 u
//   [x_i] = x_{i+1} + b_i u - a_i y,   i = 1 ... n, x_{n+1} = 0
//
// where [x] is the derivative of x, or its value at the next hit. The states have the scale of the output. Of a vector
// u each element has states of its own: the columns of an n by m matrix.
class TransferFunction {
 public:
  TransferFunction(const Array& num, const Array& den);
  Array output(const Array& x, const Array& u) const;
  Array change(const Array& x, const Array& u) const;
  // Output by input of a sampled (or continuous) system at rest.
  Value gain_at_rest(bool sampled) const;
  int order() const { return static_cast<int>(a_.size()) - 1; }
  // The states of a system whose output has been y and whose input has been u for long; where u does not ask for y in
  // the end, only the last state moves at first.
  Array at_rest(const Array& y, const Array& u, bool sampled) const;

  static void check(Checking& checking, const Table& num, const Table& den);
  // The shape of the states for an input of a known shape.
  static Shape state_shape(const Shape& den, const Shape& input);
  // The input with as many elements as there are columns of states.
  static Array as_wide_as(const Array& x, const Array& input);

 private:
  std::vector<Value> b_, a_;
};

// The solution of S X = B for a symmetric, positive definite S, by S = L D L' (G. Golub and C. Van Loan, Matrix
// Computations, 4.1); B and X are matrices.
Array solve_symmetric(const Array& S, const Array& B);

// A covariance of n numbers: n by n, its diagonal, or one number for the whole diagonal.
void check_covariance(Sizing& sizing, const Table& table, int n);
Array full_covariance(const Array& given, int n);

// x' = A x + B u (or x[k+1] = ...), y = C x + D u, written with as few brackets as possible: a vector B is a column (of
// one state: a row), a vector C a row (of one state: a column).
class LinearSystem {
 public:
  // `D` may be an empty vector: zero.
  LinearSystem(const Array& A, const Array& B, const Array& C, const Array& D);
  Array output(const Array& x, const Array& u) const;
  Array change(const Array& x, const Array& u) const;

  struct Tables {
    const Table &A, &B, &C, &D, &initial;
  };
  // Sets the shapes of x and y, and reports matrices and inputs that do not fit.
  template <typename AnyState>
  static void sizes(Sizing& sizing, const Tables& t, const Input& u, const AnyState& x, const Output& y) {
    const Dimensions d = dimensions(sizing, t);
    if (d.states > 0) sizing.set(x, Shape::vector(d.states));
    if (d.outputs > 0) sizing.set(y, one_or_many(d.outputs));
    if (d.inputs > 0) sizing.expect(u, one_or_many(d.inputs));
  }

 private:
  struct Dimensions {
    int states = 0, inputs = 0, outputs = 0;  // 0: not known
  };
  static Dimensions dimensions(Sizing& sizing, const Tables& tables);
  static Shape one_or_many(int n) { return n == 1 ? Shape::scalar() : Shape::vector(n); }
  Array A_, B_, C_, D_;
};

}  // namespace plantloop
