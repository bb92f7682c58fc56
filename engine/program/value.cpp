// Arithmetic on symbolic values: folds, element-wise maps, sums in a stated order.

#include "engine/program/value.h"

#include <fmt/format.h>

#include <cassert>
#include <utility>

namespace plantloop {

namespace {

thread_local OperationSink* current_sink = nullptr;

}  // namespace

SinkInCharge::SinkInCharge(OperationSink& sink) : previous_(current_sink) { current_sink = &sink; }
SinkInCharge::~SinkInCharge() { current_sink = previous_; }

namespace {

// The result that needs no operation, if there is one. `x - x` and `x / x` stay: they are how a NaN shows.
bool simplified(Op op, Value a, Value b, Value c, Value& result) {
  switch (op) {
    case Op::add:
      if (a.is(0)) return result = b, true;
      if (b.is(0)) return result = a, true;
      return false;
    case Op::sub:
      if (b.is(0)) return result = a, true;
      if (a.is(0)) return result = record(Op::neg, b), true;
      return false;
    case Op::mul:
      if (a.is(0) || b.is(0)) return result = 0.0, true;
      if (a.is(1)) return result = b, true;
      if (b.is(1)) return result = a, true;
      if (a.is(-1)) return result = record(Op::neg, b), true;
      if (b.is(-1)) return result = record(Op::neg, a), true;
      return false;
    case Op::div:
      if (b.is(1)) return result = a, true;
      if (b.is(-1)) return result = record(Op::neg, a), true;
      if (a.is(0) && !b.is_known()) return result = 0.0, true;
      return false;
    case Op::pow:
      if (b.is(1)) return result = a, true;
      if (b.is(0)) return result = 1.0, true;
      if (b.is(2)) return result = record(Op::mul, a, a), true;
      if (b.is(3)) return result = record(Op::mul, record(Op::mul, a, a), a), true;
      if (b.is(-1)) return result = record(Op::div, 1, a), true;
      if (b.is(0.5)) return result = record(Op::sqrt, a), true;
      return false;
    case Op::where:
      if (a.is_known()) return result = a.number() != 0 ? b : c, true;
      if (b.is_known() && c.is_known() && b.number() == c.number()) return result = b, true;
      if (!b.is_known() && !c.is_known() && b.id() == c.id()) return result = b, true;
      return false;
    case Op::logical_and:
      if (a.is(0) || b.is(0)) return result = 0.0, true;
      return false;
    case Op::logical_or:
      if ((a.is_known() && a.number() != 0) || (b.is_known() && b.number() != 0)) return result = 1.0, true;
      return false;
    default:
      return false;
  }
}

}  // namespace

Value record(Op op, Value a, Value b, Value c) {
  const int arity = arity_of(op);
  if (a.is_known() && (arity < 2 || b.is_known()) && (arity < 3 || c.is_known())) {
    return Value(apply(op, a.number(), b.number(), c.number()));
  }
  Value result;
  if (simplified(op, a, b, c, result)) return result;
  assert(current_sink != nullptr);
  return current_sink->operation(op, a, b, c);
}

std::string to_string(const Shape& shape) {
  if (shape.rank < 0) return "a size not known yet";
  if (shape.rank == 0) return "a scalar";
  if (shape.rank == 1) return fmt::format("a vector of {}", shape.rows);
  return fmt::format("a {} by {} matrix", shape.rows, shape.columns);
}

Array::Array(Shape shape, Value fill) : shape_(shape), one_(fill) {
  if (shape.rank != 0) many_.assign(static_cast<std::size_t>(shape.size()), fill);
}

Array Array::vector(std::vector<Value> values) {
  Array a;
  a.shape_ = Shape::vector(static_cast<int>(values.size()));
  a.many_ = std::move(values);
  return a;
}

Array Array::matrix(int rows, int columns, std::vector<Value> values) {
  assert(static_cast<int>(values.size()) == rows * columns);
  Array a;
  a.shape_ = Shape::matrix(rows, columns);
  a.many_ = std::move(values);
  return a;
}

bool Array::all_known() const {
  for (const Value& v : values()) {
    if (!v.is_known()) return false;
  }
  return true;
}

Array Array::spread(Shape shape) const {
  if (shape == shape_) return *this;
  if (is_scalar()) return Array(shape, one_);
  assert(size() == shape.size());
  Array a = *this;
  a.shape_ = shape;
  if (shape.rank == 0) a.one_ = many_.front();
  return a;
}

namespace {

const Shape& common_shape(const Array& a, const Array& b) {
  assert(a.is_scalar() || b.is_scalar() || a.size() == b.size());
  return a.is_scalar() ? b.shape() : a.shape();
}

}  // namespace

Array map(Op op, const Array& a) {
  if (a.is_scalar()) return Array(record(op, a[0]));
  Array result(a.shape());
  for (int i = 0; i < a.size(); ++i) result[i] = record(op, a[i]);
  return result;
}

Array map(Op op, const Array& a, const Array& b) {
  if (a.is_scalar() && b.is_scalar()) return Array(record(op, a[0], b[0]));
  Array result(common_shape(a, b));
  for (int i = 0; i < result.size(); ++i) result[i] = record(op, a.at(i), b.at(i));
  return result;
}

Array map(Op op, const Array& a, const Array& b, const Array& c) {
  if (a.is_scalar() && b.is_scalar() && c.is_scalar()) return Array(record(op, a[0], b[0], c[0]));
  Array result(a.is_scalar() ? common_shape(b, c) : a.shape());
  for (int i = 0; i < result.size(); ++i) result[i] = record(op, a.at(i), b.at(i), c.at(i));
  return result;
}

Value sum(std::span<const Value> values) {
  if (values.empty()) return 0;
  std::vector<Value> v(values.begin(), values.end());
  while (v.size() > 1) {
    const std::size_t half = (v.size() + 1) / 2;
    for (std::size_t i = 0; i + half < v.size(); ++i) v[i] = v[i] + v[i + half];
    v.resize(half);
  }
  return v.front();
}

Value dot(const Array& a, const Array& b) { return sum(map(Op::mul, a, b)); }

namespace {

Value reduce(const Array& a, Op op) {
  Value result = a.at(0);
  for (int i = 1; i < a.size(); ++i) result = record(op, result, a[i]);
  return result;
}

}  // namespace

Value least(const Array& a) { return reduce(a, Op::min); }
Value greatest(const Array& a) { return reduce(a, Op::max); }

Array mul(const Array& a, const Array& b) {
  if (a.is_scalar() || b.is_scalar()) return map(Op::mul, a, b);
  const bool row = a.shape().rank == 1 && b.shape().rank == 2;  // a vector on the left of a matrix
  const int rows = row ? 1 : a.rows();
  const int inner = row ? a.rows() : a.columns();
  const int columns = b.columns();
  assert(inner == b.rows());
  const bool is_vector = b.shape().rank == 1 || row;
  Array result(is_vector ? Shape::vector(row ? columns : rows) : Shape::matrix(rows, columns));
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      Value total = 0;
      for (int k = 0; k < inner; ++k) total = total + a[i * inner + k] * b[k * columns + j];
      result[i * columns + j] = total;
    }
  }
  return result;
}

Array transpose(const Array& a) {
  if (a.is_scalar()) return a;
  Array result(Shape::matrix(a.columns(), a.rows()));
  for (int i = 0; i < a.rows(); ++i) {
    for (int j = 0; j < a.columns(); ++j) result(j, i) = a(i, j);
  }
  return result;
}

namespace {

Value pick_between(const Array& values, int from, int until, Value index) {
  if (until - from == 1) return values.at(from);
  const int middle = (from + until) / 2;
  return where(index < static_cast<double>(middle), pick_between(values, from, middle, index),
               pick_between(values, middle, until, index));
}

}  // namespace

Value pick(const Array& values, Value index) { return pick_between(values, 0, values.size(), index); }

}  // namespace plantloop
