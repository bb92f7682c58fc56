// Functions that make one number of many.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "scripts/host/api.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

Array& numbers(lua_State* L, std::int64_t least) {
  Array& x = array_argument(L, 1, "x");
  if (x.size() < least) throw ScriptError(fmt::format("it needs at least {} numbers, here are {}", least, x.size()));
  count_elements(L, static_cast<double>(x.size()));
  return x;
}

int number(lua_State* L, double value) {
  lua_pushnumber(L, value);
  return 1;
}

// In halves, so that rounding grows with the logarithm of the length.
template <typename Term>
double sum_of(std::int64_t first, std::int64_t last, const Term& term) {
  constexpr std::int64_t few = 64;
  if (last - first > few) {
    const std::int64_t middle = first + (last - first) / 2;
    return sum_of(first, middle, term) + sum_of(middle, last, term);
  }
  double total = 0;
  for (std::int64_t i = first; i < last; ++i) total += term(i);
  return total;
}

double mean_of(const Array& x) {
  return sum_of(0, x.size(), [&](std::int64_t i) { return x.data()[i]; }) / static_cast<double>(x.size());
}

double variance_of(const Array& x) {
  const double mean = mean_of(x);
  const auto square = [&](std::int64_t i) { return (x.data()[i] - mean) * (x.data()[i] - mean); };
  return sum_of(0, x.size(), square) / static_cast<double>(x.size() - 1);
}

int sum(lua_State* L) {
  const Array& x = numbers(L, 0);
  return number(L, sum_of(0, x.size(), [&](std::int64_t i) { return x.data()[i]; }));
}
int prod(lua_State* L) {
  double product = 1;
  for (const double v : numbers(L, 0).values()) product *= v;
  return number(L, product);
}
int mean(lua_State* L) { return number(L, mean_of(numbers(L, 1))); }
int var(lua_State* L) { return number(L, variance_of(numbers(L, 2))); }
int std_deviation(lua_State* L) { return number(L, std::sqrt(variance_of(numbers(L, 2)))); }

int median(lua_State* L) {
  const Array& x = numbers(L, 1);
  Array& sorted = push_vector(L, x.values());
  double* const begin = sorted.data();
  if (std::any_of(begin, begin + sorted.size(), [](double v) { return std::isnan(v); })) return number(L, NAN);
  std::sort(begin, begin + sorted.size());
  const std::int64_t middle = sorted.size() / 2;
  return number(L, sorted.size() % 2 == 1 ? begin[middle] : (begin[middle - 1] + begin[middle]) / 2);
}

int norm(lua_State* L) {
  const Array& x = numbers(L, 0);
  double largest = 0;
  for (const double v : x.values()) largest = std::max(largest, std::fabs(v));
  if (largest == 0 || !std::isfinite(largest)) return number(L, largest);
  const auto square = [&](std::int64_t i) { return (x.data()[i] / largest) * (x.data()[i] / largest); };
  return number(L, largest * std::sqrt(sum_of(0, x.size(), square)));
}

int dot(lua_State* L) {
  const Array& a = vector_argument(L, 1, "a");
  const Array& b = vector_argument(L, 2, "b");
  if (a.size() != b.size()) throw ScriptError(fmt::format("{} meets {}", shape_text(a), shape_text(b)));
  count_elements(L, static_cast<double>(a.size()));
  return number(L, sum_of(0, a.size(), [&](std::int64_t i) { return a.data()[i] * b.data()[i]; }));
}

// Of one vector its extreme; of several arguments element by element.
template <typename Better>
int extreme(lua_State* L, Better better) {
  const int count = lua_gettop(L);
  if (count == 1) {
    const Array& x = numbers(L, 1);
    return number(L, *std::min_element(x.data(), x.data() + x.size(), better));
  }
  for (int i = 2; i <= count; ++i) {
    const Operand a = operand_argument(L, 1, "a");
    const Operand b = operand_argument(L, i, "b");
    Array* result = push_common(L, {a, b});
    if (result == nullptr) {
      lua_pushnumber(L, better(b.number, a.number) ? b.number : a.number);
    } else {
      for (std::int64_t k = 0; k < result->size(); ++k) result->data()[k] = better(b[k], a[k]) ? b[k] : a[k];
    }
    lua_replace(L, 1);
  }
  lua_settop(L, 1);
  return 1;
}

int largest(lua_State* L) {
  return extreme(L, [](double a, double b) { return a > b; });
}
int smallest(lua_State* L) {
  return extreme(L, [](double a, double b) { return a < b; });
}

int index_of_largest(lua_State* L) {
  const Array& x = numbers(L, 1);
  lua_pushinteger(L, std::max_element(x.data(), x.data() + x.size()) - x.data() + 1);
  return 1;
}
int index_of_smallest(lua_State* L) {
  const Array& x = numbers(L, 1);
  lua_pushinteger(L, std::min_element(x.data(), x.data() + x.size()) - x.data() + 1);
  return 1;
}

int any(lua_State* L) {
  const Array& x = numbers(L, 0);
  lua_pushboolean(L, std::any_of(x.data(), x.data() + x.size(), [](double v) { return v != 0; }) ? 1 : 0);
  return 1;
}
int all(lua_State* L) {
  const Array& x = numbers(L, 0);
  lua_pushboolean(L, std::all_of(x.data(), x.data() + x.size(), [](double v) { return v != 0; }) ? 1 : 0);
  return 1;
}

Entry of(std::string_view name, lua_CFunction function, std::string_view doc, std::string_view returns = "number") {
  return {name, function, "x: pl.Vector", returns, doc, true};
}

}  // namespace

Entries reductions() {
  return {
      of("sum", guarded<sum>, "the sum"),
      of("prod", guarded<prod>, "the product"),
      of("mean", guarded<mean>, "the mean"),
      of("median", guarded<median>, "the median"),
      of("var", guarded<var>, "the variance, divided by n - 1"),
      of("std", guarded<std_deviation>, "the standard deviation, the root of var"),
      of("norm", guarded<norm>, "the root of the sum of squares"),
      {"dot", guarded<dot>, "a: pl.Vector, b: pl.Vector", "number", "the sum of the products", true},
      {"max", guarded<largest>, "x: pl.Vector|number, ...: pl.Vector|number", "pl.Vector|number",
       "the largest element of a vector; of several arguments element by element", true},
      {"min", guarded<smallest>, "x: pl.Vector|number, ...: pl.Vector|number", "pl.Vector|number",
       "the smallest element of a vector; of several arguments element by element", true},
      of("argmax", guarded<index_of_largest>, "where the first largest element stands", "integer"),
      of("argmin", guarded<index_of_smallest>, "where the first smallest element stands", "integer"),
      of("any", guarded<any>, "whether an element is not 0", "boolean"),
      of("all", guarded<all>, "whether no element is 0", "boolean"),
  };
}

}  // namespace plantloop::lua
