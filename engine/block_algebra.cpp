// Limits and transfer functions.

#include "engine/block_algebra.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "engine/base/error.h"
#include "engine/program/kernel.h"

namespace plantloop {

namespace {

// Inputs of advance: what must hold, then the numbers of the message.
class Insist final : public Kernel {
 public:
  Insist(std::string path, std::string text, std::size_t numbers)
      : path_(std::move(path)), text_(std::move(text)), numbers_(numbers) {}
  std::string name() const override { return "condition"; }
  int outputs() const override { return 0; }
  bool starts_with_inputs() const override { return false; }
  void evaluate(const KernelCall&) const override {}
  void advance(const KernelCall& call) const override {
    if (call.in[0] != 0) return;
    std::array<double, 3> n{};
    std::copy_n(call.in + 1, numbers_, n.begin());
    const std::string said = fmt::format(fmt::runtime(text_), n[0], n[1], n[2]);
    throw RunError(fmt::format("at time {:g} s {}", call.time, said), call.time, path_);
  }

 private:
  std::string path_, text_;
  std::size_t numbers_;
};

}  // namespace

void follow(Now now, Jumps jump, const Discrete& state, const Array& value) {
  if (!is_sampled(now)) jump.when(becomes(!equal(value, now[state]))).set(state, value);
}

void insist(Now now, Value holds, const std::string& text, const std::vector<Value>& numbers) {
  std::vector<Value> inputs{holds};
  inputs.insert(inputs.end(), numbers.begin(), numbers.end());
  now.kernel(std::make_shared<Insist>(now.path(), text, numbers.size()), {}, std::move(inputs));
}

void stay_inside_table(Now now, const std::string& input, Value at, Value least, Value greatest) {
  insist(now, (at >= least && at <= greatest).value(),
         fmt::format("{} of block '{}' is {{0:g}}, outside its table from {{1:g}} to {{2:g}}", input, now.path()),
         {at, least, greatest});
}

Limits::Limits(Block* block, std::string_view lower_doc, std::string_view upper_doc)
    : lower(block, "lower", {.doc = lower_doc, .optional = true}),
      upper(block, "upper", {.doc = upper_doc, .optional = true}) {}

void Limits::check(Checking& checking) const { check_order(checking, lower, upper, true); }

Array Limits::clamp(Now now, Array value) const {
  if (now.given(lower)) value = max(value, now[lower]);
  if (now.given(upper)) value = min(value, now[upper]);
  return value;
}

Array Limits::stand_still(Now now, const Array& state, const Array& rate) const {
  // Between the limits the sign of the rate decides nothing, and its crossings of 0 are no events.
  Array slope = rate;
  if (now.given(lower)) slope = where(where(state <= now[lower], rate, 1.0) < 0.0, 0.0, slope);
  if (now.given(upper)) slope = where(where(state >= now[upper], rate, -1.0) > 0.0, 0.0, slope);
  return slope;
}

void Limits::stop_at_limits(Now now, Jumps jump, const State& state) const {
  if (now.given(lower)) jump.when(crossing(now[state] - now[lower], Direction::falling)).set(state, now[lower]);
  if (now.given(upper)) jump.when(crossing(now[state] - now[upper], Direction::rising)).set(state, now[upper]);
}

void check_order(Checking& checking, const Number& lower, const Number& upper, bool strictly) {
  const std::vector<double> low = checking.of(lower), high = checking.of(upper);
  if (low.empty() || high.empty()) return;
  for (std::size_t i = 0; i < std::max(low.size(), high.size()); ++i) {
    const double l = low[std::min(i, low.size() - 1)], h = high[std::min(i, high.size() - 1)];
    if (strictly ? l < h : l <= h) continue;
    return checking.problem(upper, fmt::format("'{}' must {} '{}', but they are {:g} and {:g}", upper.name,
                                               strictly ? "be greater than" : "not be less than", lower.name, h, l));
  }
}

TransferFunction::TransferFunction(const Array& num, const Array& den) {
  for (int i = 0; i < den.size(); ++i) a_.push_back(i == 0 ? Value(1.0) : den[i] / den[0]);
  b_.resize(a_.size(), 0.0);
  // From the lowest powers up; what num has beyond them are zeros.
  for (std::size_t i = 1; i <= std::min(b_.size(), static_cast<std::size_t>(num.size())); ++i) {
    b_[b_.size() - i] = num[num.size() - static_cast<int>(i)] / den[0];
  }
}

Array TransferFunction::output(const Array& x, const Array& u) const {
  Array y = b_[0] * u;
  if (order() == 0) return y;
  for (int e = 0; e < y.size(); ++e) y[e] = x[e] + y[e];
  return y;
}

Array TransferFunction::change(const Array& x, const Array& u) const {
  const Array y = output(x, u);
  const int width = u.size();
  Array result(x.shape());
  for (std::size_t i = 1; i < a_.size(); ++i) {
    for (int e = 0; e < width; ++e) {
      const int at = static_cast<int>(i - 1) * width + e;
      const Value next = i + 1 < a_.size() ? x[at + width] : Value(0);
      result[at] = next + b_[i] * u.at(e) - a_[i] * y[e];
    }
  }
  return result;
}

Array TransferFunction::at_rest(const Array& y, const Array& u, bool sampled) const {
  const int width = u.size();
  Array x(width == 1 ? Shape::vector(order()) : Shape::matrix(order(), width));
  for (std::size_t i = 0; i + 1 < a_.size(); ++i) {
    for (int e = 0; e < width; ++e) {
      const int at = static_cast<int>(i) * width + e;
      const Value before = sampled && i > 0 ? x[at - width] : Value(0);
      x[at] = before + a_[i] * y.at(e) - b_[i] * u.at(e);
    }
  }
  return x;
}

Value TransferFunction::gain_at_rest(bool sampled) const { return sampled ? sum(b_) / sum(a_) : b_.back() / a_.back(); }

Array TransferFunction::as_wide_as(const Array& x, const Array& input) {
  const int width = x.shape().rank == 2 ? x.columns() : 1;
  return width == 1 ? input : input.spread(Shape::vector(width));
}

void TransferFunction::check(Checking& checking, const Table& num, const Table& den) {
  const std::vector<double> n = checking.of(num), d = checking.of(den);
  if (n.empty()) return checking.problem(num, "num needs at least one coefficient");
  if (d.empty()) return checking.problem(den, "den needs at least one coefficient");
  if (checking.shape(num).rank == 2 || checking.shape(den).rank == 2) {
    return checking.problem(num, "num and den are vectors of coefficients, [1, 2]");
  }
  if (d[0] == 0) return checking.problem(den, "the first coefficient of den is 0: leave it out");
  const auto first = std::find_if(n.begin(), n.end(), [](double c) { return c != 0; });
  const auto degree = n.end() - first;
  if (degree <= static_cast<std::ptrdiff_t>(d.size())) return;
  checking.problem(num, fmt::format("num has degree {} and den {}: a transfer function whose output would need "
                                    "derivatives of its input cannot be built",
                                    degree - 1, d.size() - 1));
}

Shape TransferFunction::state_shape(const Shape& den, const Shape& input) {
  if (!den.is_known() || !input.is_known()) return Shape::unknown();
  const int order = den.size() - 1;
  return input.size() == 1 ? Shape::vector(order) : Shape::matrix(order, input.size());
}

void check_covariance(Sizing& sizing, const Table& table, int n) {
  const Shape s = sizing.of(table);
  if (!s.is_known() || s.size() == 1 || s == Shape::vector(n) || s == Shape::matrix(n, n)) return;
  sizing.problem(table, fmt::format("{} must be {} by {}, its diagonal or one number, but it is {}", table.name, n, n,
                                    to_string(s)));
}

Array full_covariance(const Array& given, int n) {
  if (given.shape() == Shape::matrix(n, n)) return given;
  Array matrix(Shape::matrix(n, n));
  for (int i = 0; i < n; ++i) matrix(i, i) = given.size() == 1 ? given[0] : given[i];
  return matrix;
}

Array solve_symmetric(const Array& S, const Array& B) {
  const int n = S.rows();
  Array L(Shape::matrix(n, n)), X = B;
  std::vector<Value> D(static_cast<std::size_t>(n));
  const auto d = [&](int i) -> Value& { return D[static_cast<std::size_t>(i)]; };
  for (int j = 0; j < n; ++j) {
    d(j) = S(j, j);
    for (int k = 0; k < j; ++k) d(j) = d(j) - L(j, k) * L(j, k) * d(k);
    for (int i = j + 1; i < n; ++i) {
      Value entry = S(i, j);
      for (int k = 0; k < j; ++k) entry = entry - L(i, k) * L(j, k) * d(k);
      L(i, j) = entry / d(j);
    }
  }
  for (int c = 0; c < X.columns(); ++c) {
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < i; ++k) X(i, c) = X(i, c) - L(i, k) * X(k, c);
    }
    for (int i = 0; i < n; ++i) X(i, c) = X(i, c) / d(i);
    for (int i = n; i-- > 0;) {
      for (int k = i + 1; k < n; ++k) X(i, c) = X(i, c) - L(k, i) * X(k, c);
    }
  }
  return X;
}

LinearSystem::LinearSystem(const Array& A, const Array& B, const Array& C, const Array& D) {
  const int n = A.rows(), m = B.size() / n, p = C.size() / n;
  A_ = A.spread(Shape::matrix(n, n));
  B_ = B.spread(Shape::matrix(n, m));
  C_ = C.spread(Shape::matrix(p, n));
  D_ = D.size() == 0 ? Array(Shape::matrix(p, m)) : D.spread(Shape::matrix(p, m));
}

Array LinearSystem::output(const Array& x, const Array& u) const {
  const Array y = mul(C_, x) + mul(D_, u.spread(Shape::vector(D_.columns())));
  return y.size() == 1 ? y.spread(Shape::scalar()) : y;
}

Array LinearSystem::change(const Array& x, const Array& u) const {
  return mul(A_, x) + mul(B_, u.spread(Shape::vector(B_.columns())));
}

LinearSystem::Dimensions LinearSystem::dimensions(Sizing& sizing, const Tables& t) {
  Dimensions d;
  const Shape a = sizing.of(t.A), b = sizing.of(t.B), c = sizing.of(t.C), e = sizing.of(t.D), x0 = sizing.of(t.initial);
  if (!a.is_known()) return d;
  if (a.rows != a.columns) {
    sizing.problem(t.A, fmt::format("A must be square, but it is {}", to_string(a)));
    return d;
  }
  const int n = d.states = a.rows;
  if (b.is_known()) {
    const int rows = b.rank == 1 && n == 1 ? 1 : b.rows;
    if (rows == n) d.inputs = b.size() / n;
    if (rows != n) sizing.problem(t.B, fmt::format("B has {} rows, A has {}", rows, n));
  }
  if (c.is_known()) {
    const int columns = c.rank == 1 ? (n == 1 ? 1 : c.rows) : c.columns;
    if (columns == n) d.outputs = c.size() / n;
    if (columns != n) sizing.problem(t.C, fmt::format("C has {} columns, A has {} rows", columns, n));
  }
  if (e.is_known() && d.inputs > 0 && d.outputs > 0) {
    const bool fits = e.rank == 2 ? e.rows == d.outputs && e.columns == d.inputs
                                  : e.size() == d.inputs * d.outputs && (d.inputs == 1 || d.outputs == 1);
    if (!fits) {
      sizing.problem(
          t.D, fmt::format("D must be {} by {} (outputs by inputs), but it is {}", d.outputs, d.inputs, to_string(e)));
    }
  }
  if (x0.is_known() && x0.size() != 1 && x0.size() != n) {
    sizing.problem(t.initial,
                   fmt::format("initial must have {} elements, one for each state, but it is {}", n, to_string(x0)));
  }
  return d;
}

}  // namespace plantloop
