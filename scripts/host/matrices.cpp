// Linear algebra: products, equations, polynomials.

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "scripts/host/api.h"
#include "scripts/host/session.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

int transpose(lua_State* L) {
  const Array& a = array_argument(L, 1, "A");
  Array& result = push_array(L, a.columns, a.rows, true);
  matrix_view(result) = matrix_view(a).transpose();
  return 1;
}

int multiply(lua_State* L) {
  const Array& a = array_argument(L, 1, "A");
  const Array& b = array_argument(L, 2, "B");
  if (a.columns != b.rows) {
    throw ScriptError(fmt::format("{} times {}: the columns of the first must be as many as the rows of the second",
                                  shape_text(a), shape_text(b)));
  }
  Array& result = push_array(L, a.rows, b.columns, a.is_matrix && b.is_matrix);
  // Some columns at a time, so that a long product can be stopped.
  const double each = static_cast<double>(a.rows) * static_cast<double>(a.columns) + 1;
  const auto some = std::max<std::int64_t>(1, static_cast<std::int64_t>(1e7 / each));
  for (std::int64_t at = 0; at < b.columns; at += some) {
    const std::int64_t count = std::min(some, b.columns - at);
    matrix_view(result).middleCols(at, count).noalias() = matrix_view(a) * matrix_view(b).middleCols(at, count);
    session_of(L).sandbox.work(L, each * static_cast<double>(count) / 4);
  }
  return 1;
}

// Work with the cube of a size is one piece, so it must not be too large.
void refuse_large(const char* what, double operations) {
  constexpr double most = 5e10;
  if (operations > most) throw ScriptError(fmt::format("{} is too large for a script", what));
}

int solve(lua_State* L) {
  const Array& a = array_argument(L, 1, "A");
  const Array& b = array_argument(L, 2, "b");
  if (a.rows != b.rows) throw ScriptError(fmt::format("{} and {} have not as many rows", shape_text(a), shape_text(b)));
  const double rows = static_cast<double>(a.rows);
  refuse_large("this system of equations", rows * static_cast<double>(a.columns) *
                                               (static_cast<double>(a.columns) + static_cast<double>(b.columns)));
  session_of(L).sandbox.hold(L, 2 * static_cast<std::size_t>(a.size()) * sizeof(double));
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factors(matrix_view(a));
  const bool has_full_rank = factors.rank() == a.columns;
  Eigen::MatrixXd x;
  if (has_full_rank) x = factors.solve(matrix_view(b));
  session_of(L).sandbox.release(2 * static_cast<std::size_t>(a.size()) * sizeof(double));
  if (!has_full_rank) throw ScriptError(fmt::format("A has rank {}, which is not {}", factors.rank(), a.columns));
  Array& result = push_array(L, a.columns, b.columns, b.is_matrix);
  matrix_view(result) = x;
  return 1;
}

int eigenvalues(lua_State* L) {
  const Array& a = array_argument(L, 1, "A");
  if (a.rows != a.columns) throw ScriptError(fmt::format("A must be square, it is {}", shape_text(a)));
  refuse_large("this matrix", 10 * std::pow(static_cast<double>(a.rows), 3));
  if (!matrix_view(a).allFinite()) throw ScriptError("A must be finite numbers");
  Eigen::VectorXcd values;
  if (a.rows > 0) values = Eigen::EigenSolver<Eigen::MatrixXd>(matrix_view(a), false).eigenvalues();
  std::vector<std::complex<double>> sorted(values.data(), values.data() + values.size());
  std::sort(sorted.begin(), sorted.end(), [](const auto& one, const auto& other) {
    return one.real() != other.real() ? one.real() < other.real() : one.imag() < other.imag();
  });
  Array& real = push_vector(L, a.rows);
  Array& imaginary = push_vector(L, a.rows);
  for (std::int64_t i = 0; i < a.rows; ++i) {
    real.data()[i] = sorted[static_cast<std::size_t>(i)].real();
    imaginary.data()[i] = sorted[static_cast<std::size_t>(i)].imag();
  }
  return 2;
}

int polyfit(lua_State* L) {
  const Array& x = vector_argument(L, 1, "x");
  const Array& y = vector_argument(L, 2, "y");
  if (x.size() != y.size()) throw ScriptError(fmt::format("x has {} numbers and y has {}", x.size(), y.size()));
  const std::int64_t degree = integer_argument(L, 3, "degree", 0, std::max<std::int64_t>(x.size() - 1, 0));
  refuse_large("this fit", static_cast<double>(x.size()) * std::pow(static_cast<double>(degree + 1), 2));
  Array& powers = push_array(L, x.size(), degree + 1, true);
  for (std::int64_t i = 0; i < x.size(); ++i) {
    for (std::int64_t k = 0; k <= degree; ++k) {
      powers.data()[i + k * x.size()] = std::pow(x.data()[i], static_cast<double>(degree - k));
    }
  }
  lua_replace(L, 1);
  lua_settop(L, 2);
  return solve(L);
}

int polyval(lua_State* L) {
  const Array& coefficients = vector_argument(L, 1, "coefficients");
  const Operand x = operand_argument(L, 2, "x");
  const auto value = [&](double at) {
    double sum = 0;
    for (const double c : coefficients.values()) sum = sum * at + c;
    return sum;
  };
  Array* result = push_common(L, {x});
  if (result == nullptr) {
    lua_pushnumber(L, value(x.number));
    return 1;
  }
  for (std::int64_t i = 0; i < result->size(); ++i) {
    result->data()[i] = value(x[i]);
    if (i % 1024 == 0) count_elements(L, 1024 * static_cast<double>(coefficients.size()));
  }
  return 1;
}

}  // namespace

Entries matrix_functions() {
  return {
      {"transpose", guarded<transpose>, "A: pl.Vector", "pl.Vector", "rows as columns; of a vector a matrix of one row",
       true},
      {"mul", guarded<multiply>, "A: pl.Vector, B: pl.Vector", "pl.Vector", "the product of matrices", true},
      {"solve", guarded<solve>, "A: pl.Vector, b: pl.Vector", "pl.Vector",
       "x with A x = b; with more rows than columns the least squares", true},
      {"eigenvalues", guarded<eigenvalues>, "A: pl.Vector", "pl.Vector, pl.Vector",
       "real and imaginary parts of the eigenvalues, ascending", true},
      {"polyfit", guarded<polyfit>, "x: pl.Vector, y: pl.Vector, degree: integer", "pl.Vector",
       "the polynomial through the points with the least squares; descending powers"},
      {"polyval", guarded<polyval>, "coefficients: pl.Vector, x: pl.Vector|number", "pl.Vector|number",
       "the polynomial's values; coefficients in descending powers"},
  };
}

}  // namespace plantloop::lua
