// Functions that make vectors and matrices.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scripts/host/api.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

constexpr std::int64_t most = std::int64_t{1} << 40;  // the memory limit comes first

int vector(lua_State* L) {
  if (lua_gettop(L) != 1 || lua_type(L, 1) == LUA_TNUMBER) {
    throw ScriptError("it takes one list, as in pl.vector{1, 2, 3}");
  }
  const Array& a = vector_argument(L, 1, "list");
  push_vector(L, a.values());
  return 1;
}

int matrix(lua_State* L) {
  const Array& a = array_argument(L, 1, "rows");
  Array& result = push_array(L, a.rows, a.columns, true);
  std::copy(a.data(), a.data() + a.size(), result.data());
  return 1;
}

int filled(lua_State* L, double value) {
  const std::int64_t rows = integer_argument(L, 1, "rows", 0, most);
  const bool is_matrix = is_given(L, 2);
  const std::int64_t columns = is_matrix ? integer_argument(L, 2, "columns", 0, most) : 1;
  Array& a = push_array(L, rows, columns, is_matrix);
  std::fill(a.data(), a.data() + a.size(), value);
  return 1;
}

int zeros(lua_State* L) { return filled(L, 0); }
int ones(lua_State* L) { return filled(L, 1); }

int eye(lua_State* L) {
  const std::int64_t size = integer_argument(L, 1, "size", 0, most);
  Array& a = push_array(L, size, size, true);
  matrix_view(a).setIdentity();
  return 1;
}

double finite(lua_State* L, int index, std::string_view what) {
  const double value = number_argument(L, index, what);
  if (!std::isfinite(value)) throw ScriptError(fmt::format("'{}' must be a finite number, it is {}", what, value));
  return value;
}

int linspace(lua_State* L) {
  const double from = finite(L, 1, "from");
  const double to = finite(L, 2, "to");
  const std::int64_t count = is_given(L, 3) ? integer_argument(L, 3, "count", 2, most) : 101;
  Array& a = push_vector(L, count);
  const double step = (to - from) / static_cast<double>(count - 1);
  for (std::int64_t i = 0; i < count; ++i) a.data()[i] = i + 1 == count ? to : from + step * static_cast<double>(i);
  return 1;
}

int logspace(lua_State* L) {
  const double from = finite(L, 1, "from");
  const double to = finite(L, 2, "to");
  const std::int64_t count = is_given(L, 3) ? integer_argument(L, 3, "count", 2, most) : 101;
  if (!(from > 0 && to > 0)) throw ScriptError("both ends must be greater than 0");
  Array& a = push_vector(L, count);
  const double step = std::log(to / from) / static_cast<double>(count - 1);
  for (std::int64_t i = 0; i < count; ++i) {
    a.data()[i] = i == 0 ? from : i + 1 == count ? to : from * std::exp(step * static_cast<double>(i));
  }
  return 1;
}

int range(lua_State* L) {
  const double from = finite(L, 1, "from");
  const double to = finite(L, 2, "to");
  const double step = is_given(L, 3) ? finite(L, 3, "step") : 1;
  if (step == 0) throw ScriptError("'step' must not be 0");
  // A millionth of a step past the end still counts as the end.
  const double count = std::floor((to - from) / step + 1e-6) + 1;
  if (!(count < static_cast<double>(most))) throw ScriptError("there are too many numbers in this range");
  Array& a = push_vector(L, count > 0 ? static_cast<std::int64_t>(count) : 0);
  for (std::int64_t i = 0; i < a.size(); ++i) a.data()[i] = from + step * static_cast<double>(i);
  return 1;
}

int join(lua_State* L) {
  const int count = lua_gettop(L);
  std::int64_t size = 0;
  for (int i = 1; i <= count; ++i) size += vector_argument(L, i, "part").size();
  double* out = push_vector(L, size).data();
  for (int i = 1; i <= count; ++i) {
    const Array& part = *test_array(L, i);
    out = std::copy(part.data(), part.data() + part.size(), out);
  }
  return 1;
}

}  // namespace

Entries vector_makers() {
  return {
      {"vector", guarded<vector>, "list: number[]", "pl.Vector", "a vector with the numbers of a list"},
      {"matrix", guarded<matrix>, "rows: number[][]", "pl.Vector", "a matrix, given by its rows"},
      {"zeros", guarded<zeros>, "rows: integer, columns?: integer", "pl.Vector", "a vector or matrix of zeros"},
      {"ones", guarded<ones>, "rows: integer, columns?: integer", "pl.Vector", "a vector or matrix of ones"},
      {"eye", guarded<eye>, "size: integer", "pl.Vector", "the identity matrix"},
      {"linspace", guarded<linspace>, "from: number, to: number, count?: integer", "pl.Vector",
       "equally spaced numbers, both ends included; 101 if not told"},
      {"logspace", guarded<logspace>, "from: number, to: number, count?: integer", "pl.Vector",
       "numbers with equal ratios, both ends included; 101 if not told"},
      {"range", guarded<range>, "from: number, to: number, step?: number", "pl.Vector",
       "from, from + step, ... up to and including `to` where it is met"},
      {"join", guarded<join>, "...: pl.Vector|number", "pl.Vector", "the vectors and numbers, one after the other"},
  };
}

}  // namespace plantloop::lua
