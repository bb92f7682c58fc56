// From roots to coefficients; the parameters and sections of Butterworth filters.

#include "engine/block_design.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>

namespace plantloop {

namespace {

using Complex = std::complex<double>;

std::vector<Complex> roots_of(Checking& checking, const Table& table) {
  std::vector<Complex> roots;
  if (!checking.given(table)) return roots;
  const std::vector<double> numbers = checking.of(table);
  const Shape shape = checking.shape(table);
  if (shape.rank != 2) return {numbers.begin(), numbers.end()};
  if (shape.columns != 2) {
    checking.problem(
        table, fmt::format("each row is a complex number, [real, imaginary], but there are {} columns", shape.columns));
    return roots;
  }
  for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) roots.emplace_back(numbers[i], numbers[i + 1]);
  for (const Complex& root : roots) {
    const auto times = [&](const Complex& r) { return std::count(roots.begin(), roots.end(), r); };
    if (root.imag() == 0 || times(root) == times(std::conj(root))) continue;
    checking.problem(table, fmt::format("complex ones come in pairs: beside [{:g}, {:g}] there must be [{:g}, {:g}]",
                                        root.real(), root.imag(), root.real(), -root.imag()));
    break;
  }
  return roots;
}

}  // namespace

void Roots::check(Checking& checking, const Table& zeros, const Table& poles) {
  const std::size_t above = roots_of(checking, zeros).size(), below = roots_of(checking, poles).size();
  if (above <= below) return;
  checking.problem(zeros, fmt::format("there are more zeros, {}, than poles, {}: a filter whose output would need "
                                      "derivatives or future values of its input cannot be built",
                                      above, below));
}

Shape Roots::polynomial_shape(const Shape& roots) {
  if (!roots.is_known()) return roots;
  return Shape::vector((roots.rank == 2 ? roots.rows : roots.size()) + 1);
}

// By complex arithmetic; the imaginary parts of the result vanish, since conjugates come in pairs.
Array Roots::polynomial(const Array& roots) {
  const bool complex = roots.shape().rank == 2;
  const int n = complex ? roots.rows() : roots.size();
  std::vector<Value> real{1.0}, imaginary{0.0};
  for (int i = 0; i < n; ++i) {
    const Value a = complex ? roots(i, 0) : roots[i], b = complex ? roots(i, 1) : Value(0);
    real.emplace_back(0.0), imaginary.emplace_back(0.0);
    for (std::size_t k = real.size() - 1; k >= 1; --k) {
      const Value re = real[k - 1], im = imaginary[k - 1];
      real[k] = real[k] - (re * a - im * b);
      imaginary[k] = imaginary[k] - (re * b + im * a);
    }
  }
  return Array::vector(std::move(real));
}

Butterworth::Butterworth(Block* block)
    : kind(block, "kind", {.of = {"lowpass", "highpass", "bandpass", "bandstop"}, .doc = "what passes"}),
      order(block, "order", {.init = 2, .doc = "poles of the lowpass that it is made from", .min = 1, .max = 50}),
      frequency(block, "frequency",
                {.init = 1,
                 .unit = "rad/s",
                 .doc = "cut-off of a lowpass or highpass; 2*pi*f for f in Hz",
                 .above = 0,
                 .size = Size::Kind::scalar}),
      lower(block, "lower",
            {.unit = "rad/s",
             .doc = "lower cut-off of a bandpass or bandstop",
             .above = 0,
             .size = Size::Kind::scalar,
             .optional = true}),
      upper(block, "upper",
            {.unit = "rad/s",
             .doc = "upper cut-off of a bandpass or bandstop",
             .above = 0,
             .size = Size::Kind::scalar,
             .optional = true}) {}

void Butterworth::check(Checking& checking) const {
  const bool low = checking.given(lower), high = checking.given(upper);
  if (!is_band() && (low || high)) {
    return checking.problem(low ? lower : upper, fmt::format("a {} has one cut-off, `frequency`", kind.value()));
  }
  if (!is_band()) return;
  if (!low || !high) {
    return checking.problem(kind, fmt::format("a {} needs `lower` and `upper`, its cut-offs in rad/s", kind.value()));
  }
  const double from = checking.of(lower).empty() ? 0 : checking.of(lower)[0];
  const double to = checking.of(upper).empty() ? unbounded : checking.of(upper)[0];
  if (from < to) return;
  checking.problem(upper, fmt::format("'upper' must be greater than 'lower', but they are {:g} and {:g}", to, from));
}

std::vector<double> Butterworth::sections() const {
  constexpr double pi = 3.14159265358979323846;
  const int n = order.value();
  std::vector<double> dampings;
  for (int i = 1; i <= n / 2; ++i) dampings.push_back(2 * std::sin((2 * i - 1) * pi / (2 * n)));
  if (n % 2 == 1) dampings.push_back(first_order);
  return dampings;
}

}  // namespace plantloop
