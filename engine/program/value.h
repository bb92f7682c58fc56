// Symbolic values: what a block's equations are written on. Arithmetic on them is recorded as operations of the
// Recorder in charge.
//
// A Value is a known number or a node of the record. Known numbers fold at once, so zeros and ones of matrices vanish
// before a node exists, and Values work where no recorder is in charge as long as all of them are known. Folds are
// exact for finite values but for the sign of zero: x + 0 = x, 1 * x = x, 0 * x = 0.

#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/program/operations.h"

namespace plantloop {

class Value {
 public:
  Value(double number = 0) : number_(number) {}  // NOLINT: numbers are values
  static Value node(std::uint32_t id) {
    Value v;
    v.id_ = id;
    return v;
  }
  bool is_known() const { return id_ == known; }
  double number() const { return number_; }  // only when known
  std::uint32_t id() const { return id_; }   // only when not known
  bool is(double number) const { return is_known() && number_ == number; }

 private:
  static constexpr std::uint32_t known = 0xffffffff;
  double number_ = 0;
  std::uint32_t id_ = known;
};

// A condition. It has no conversion to bool, so `if` on a signal does not compile: use where(condition, a, b).
class Truth {
 public:
  explicit Truth(Value value) : value_(value) {}
  Value value() const { return value_; }  // 0 or 1

 private:
  Value value_;
};

// Takes the operations that arithmetic on Values makes.
class OperationSink {
 public:
  virtual ~OperationSink() = default;
  virtual Value operation(Op op, Value a, Value b, Value c) = 0;
};

// Puts a sink in charge of this thread's arithmetic for as long as it lives.
class SinkInCharge {
 public:
  explicit SinkInCharge(OperationSink& sink);
  ~SinkInCharge();
  SinkInCharge(const SinkInCharge&) = delete;
  SinkInCharge& operator=(const SinkInCharge&) = delete;

 private:
  OperationSink* previous_;
};

// Records one operation with the sink in charge, folding what is known.
Value record(Op op, Value a, Value b = 0, Value c = 0);

inline Value operator-(Value a) { return record(Op::neg, a); }
inline Value operator+(Value a, Value b) { return record(Op::add, a, b); }
inline Value operator-(Value a, Value b) { return record(Op::sub, a, b); }
inline Value operator*(Value a, Value b) { return record(Op::mul, a, b); }
inline Value operator/(Value a, Value b) { return record(Op::div, a, b); }
inline Truth operator<(Value a, Value b) { return Truth(record(Op::less, a, b)); }
inline Truth operator<=(Value a, Value b) { return Truth(record(Op::less_equal, a, b)); }
inline Truth operator>(Value a, Value b) { return Truth(record(Op::less, b, a)); }
inline Truth operator>=(Value a, Value b) { return Truth(record(Op::less_equal, b, a)); }
inline Truth equal(Value a, Value b) { return Truth(record(Op::equal, a, b)); }
inline Truth operator!(Truth a) { return Truth(record(Op::logical_not, a.value())); }
inline Truth operator&&(Truth a, Truth b) { return Truth(record(Op::logical_and, a.value(), b.value())); }
inline Truth operator||(Truth a, Truth b) { return Truth(record(Op::logical_or, a.value(), b.value())); }
inline Value where(Truth condition, Value a, Value b) { return record(Op::where, condition.value(), a, b); }

// The shape of a signal or parameter: a scalar (rank 0), a vector (1) or a matrix (2); rank -1: not known yet.
struct Shape {
  int rank = 0;
  int rows = 1;
  int columns = 1;
  static Shape unknown() { return {-1, 0, 0}; }
  static Shape scalar() { return {0, 1, 1}; }
  static Shape vector(int n) { return {1, n, 1}; }
  static Shape matrix(int rows, int columns) { return {2, rows, columns}; }
  bool is_known() const { return rank >= 0; }
  bool is_scalar() const { return rank == 0; }
  int size() const { return rows * columns; }
  friend bool operator==(const Shape&, const Shape&) = default;
};
// "a scalar", "a vector of 3", "a 2 by 3 matrix"
std::string to_string(const Shape& shape);

// A scalar, vector or matrix of Values (row by row), with element-wise arithmetic in which a scalar meets anything.
// Shapes that do not fit are asserted: elaboration has checked them.
class Array {
 public:
  Array(double number = 0) : one_(number) {}  // NOLINT: numbers are arrays
  Array(Value value) : one_(value) {}         // NOLINT: values are arrays
  explicit Array(Shape shape, Value fill = 0);
  static Array vector(std::vector<Value> values);
  static Array matrix(int rows, int columns, std::vector<Value> values);

  const Shape& shape() const { return shape_; }
  int size() const { return shape_.size(); }
  int rows() const { return shape_.rows; }
  int columns() const { return shape_.columns; }
  bool is_scalar() const { return shape_.rank == 0; }
  bool all_known() const;

  Value& operator[](int i) { return shape_.rank == 0 ? one_ : many_[static_cast<std::size_t>(i)]; }
  const Value& operator[](int i) const { return shape_.rank == 0 ? one_ : many_[static_cast<std::size_t>(i)]; }
  Value& operator()(int row, int column) { return (*this)[row * shape_.columns + column]; }
  const Value& operator()(int row, int column) const { return (*this)[row * shape_.columns + column]; }
  // Element i, or the scalar itself whatever i is.
  const Value& at(int i) const { return is_scalar() ? one_ : many_[static_cast<std::size_t>(i)]; }
  std::span<const Value> values() const {
    return shape_.rank == 0 ? std::span<const Value>(&one_, 1) : std::span<const Value>(many_);
  }
  // The same with another shape of equal size, e.g. a scalar spread to a vector when the shape is larger.
  Array spread(Shape shape) const;

 private:
  Shape shape_;
  Value one_;
  std::vector<Value> many_;
};
using Vector = Array;
using Matrix = Array;

// An Array of conditions (0 or 1), without conversion to bool.
struct Truths {
  Array array;
  Truth operator[](int i) const { return Truth(array.at(i)); }
};

Array map(Op op, const Array& a);
Array map(Op op, const Array& a, const Array& b);
Array map(Op op, const Array& a, const Array& b, const Array& c);

inline Array operator-(const Array& a) { return map(Op::neg, a); }
#define PLANTLOOP_ARITHMETIC(symbol, op)                                                      \
  inline Array operator symbol(const Array& a, const Array& b) { return map(Op::op, a, b); }  \
  inline Array operator symbol(const Array& a, Value b) { return map(Op::op, a, Array(b)); }  \
  inline Array operator symbol(Value a, const Array& b) { return map(Op::op, Array(a), b); }  \
  inline Array operator symbol(const Array& a, double b) { return map(Op::op, a, Array(b)); } \
  inline Array operator symbol(double a, const Array& b) { return map(Op::op, Array(a), b); }
PLANTLOOP_ARITHMETIC(+, add)
PLANTLOOP_ARITHMETIC(-, sub)
PLANTLOOP_ARITHMETIC(*, mul)
PLANTLOOP_ARITHMETIC(/, div)
#undef PLANTLOOP_ARITHMETIC
// Mixed forms, so that a number beside a Value is not ambiguous.
#define PLANTLOOP_ARITHMETIC(symbol)                                            \
  inline Value operator symbol(Value a, double b) { return a symbol Value(b); } \
  inline Value operator symbol(double a, Value b) { return Value(a) symbol b; }
PLANTLOOP_ARITHMETIC(+)
PLANTLOOP_ARITHMETIC(-)
PLANTLOOP_ARITHMETIC(*)
PLANTLOOP_ARITHMETIC(/)
#undef PLANTLOOP_ARITHMETIC
#define PLANTLOOP_COMPARISON(symbol, op, first, second)                                                  \
  inline Truths operator symbol(const Array& a, const Array& b) { return {map(Op::op, first, second)}; } \
  inline Truths operator symbol(const Array& a, double b) { return a symbol Array(b); }                  \
  inline Truths operator symbol(double a, const Array& b) { return Array(a) symbol b; }                  \
  inline Truth operator symbol(Value a, double b) { return a symbol Value(b); }                          \
  inline Truth operator symbol(double a, Value b) { return Value(a) symbol b; }
PLANTLOOP_COMPARISON(<, less, a, b)
PLANTLOOP_COMPARISON(<=, less_equal, a, b)
PLANTLOOP_COMPARISON(>, less, b, a)
PLANTLOOP_COMPARISON(>=, less_equal, b, a)
#undef PLANTLOOP_COMPARISON
inline Truths equal(const Array& a, const Array& b) { return {map(Op::equal, a, b)}; }
inline Truths operator!(const Truths& a) { return {map(Op::logical_not, a.array)}; }
inline Truths operator&&(const Truths& a, const Truths& b) { return {map(Op::logical_and, a.array, b.array)}; }
inline Truths operator||(const Truths& a, const Truths& b) { return {map(Op::logical_or, a.array, b.array)}; }
inline Array where(const Truths& condition, const Array& a, const Array& b) {
  return map(Op::where, condition.array, a, b);
}
inline Value where(Truth condition, double a, double b) { return where(condition, Value(a), Value(b)); }
inline Array where(Truth condition, const Array& a, const Array& b) {
  return map(Op::where, Array(condition.value()), a, b);
}

#define PLANTLOOP_FUNCTION(name)                             \
  inline Value name(Value a) { return record(Op::name, a); } \
  inline Array name(const Array& a) { return map(Op::name, a); }
PLANTLOOP_FUNCTION(abs)
PLANTLOOP_FUNCTION(sqrt)
PLANTLOOP_FUNCTION(cbrt)
PLANTLOOP_FUNCTION(exp)
PLANTLOOP_FUNCTION(log)
PLANTLOOP_FUNCTION(log2)
PLANTLOOP_FUNCTION(log10)
PLANTLOOP_FUNCTION(sin)
PLANTLOOP_FUNCTION(cos)
PLANTLOOP_FUNCTION(tan)
PLANTLOOP_FUNCTION(asin)
PLANTLOOP_FUNCTION(acos)
PLANTLOOP_FUNCTION(atan)
PLANTLOOP_FUNCTION(sinh)
PLANTLOOP_FUNCTION(cosh)
PLANTLOOP_FUNCTION(tanh)
PLANTLOOP_FUNCTION(asinh)
PLANTLOOP_FUNCTION(acosh)
PLANTLOOP_FUNCTION(atanh)
PLANTLOOP_FUNCTION(erf)
PLANTLOOP_FUNCTION(floor)
PLANTLOOP_FUNCTION(ceil)
PLANTLOOP_FUNCTION(round)
PLANTLOOP_FUNCTION(trunc)
PLANTLOOP_FUNCTION(sign)
#undef PLANTLOOP_FUNCTION
#define PLANTLOOP_FUNCTION(name)                                         \
  inline Value name(Value a, Value b) { return record(Op::name, a, b); } \
  inline Array name(const Array& a, const Array& b) { return map(Op::name, a, b); }
PLANTLOOP_FUNCTION(pow)
PLANTLOOP_FUNCTION(atan2)
PLANTLOOP_FUNCTION(hypot)
PLANTLOOP_FUNCTION(mod)
PLANTLOOP_FUNCTION(min)
PLANTLOOP_FUNCTION(max)
#undef PLANTLOOP_FUNCTION

// Sums are recorded by halving, v[i] + v[i + n/2]: a defined order that runs wide. `sum` of nothing is 0.
Value sum(std::span<const Value> values);
inline Value sum(const Array& a) { return sum(a.values()); }
Value dot(const Array& a, const Array& b);
Value least(const Array& a);     // the least element
Value greatest(const Array& a);  // the greatest element
// The matrix product; a vector on the right is a column, a vector on the left of a matrix is a row. The order of each
// sum is that of `running_sum`: left to right, so that rows run as wide multiply-adds.
Array mul(const Array& a, const Array& b);
Array transpose(const Array& a);
// Element `index` (counted from 0) of the values; below 0 the first one, beyond the end the last one.
Value pick(const Array& values, Value index);

}  // namespace plantloop
