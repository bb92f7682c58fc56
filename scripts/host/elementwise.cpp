// Functions that work element by element, on numbers as well as on vectors and matrices. As in diagrams' expressions.

#include <algorithm>
#include <cmath>

#include "scripts/host/api.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

template <typename Function>
int map(lua_State* L, Function function) {
  const Operand x = operand_argument(L, 1, "x");
  if (x.array == nullptr) {
    lua_pushnumber(L, function(x.number));
    return 1;
  }
  Array& result = push_like(L, *x.array);
  count_elements(L, 4 * static_cast<double>(result.size()));
  std::transform(x.array->data(), x.array->data() + x.array->size(), result.data(), function);
  return 1;
}

template <typename Function>
int map_two(lua_State* L, Function function) {
  const Operand a = operand_argument(L, 1, "a");
  const Operand b = operand_argument(L, 2, "b");
  Array* result = push_common(L, {a, b});
  if (result == nullptr) {
    lua_pushnumber(L, function(a.number, b.number));
    return 1;
  }
  for (std::int64_t i = 0, n = result->size(); i < n; ++i) result->data()[i] = function(a[i], b[i]);
  return 1;
}

template <double (*function)(double)>
int math(lua_State* L) {
  return map(L, function);
}

double sign(double x) { return x > 0 ? 1 : x < 0 ? -1 : x; }

int arc_tangent(lua_State* L) {
  if (!is_given(L, 2)) return map(L, [](double x) { return std::atan(x); });
  return map_two(L, [](double y, double x) { return std::atan2(y, x); });
}
int modulo(lua_State* L) {
  return map_two(L, [](double a, double b) { return a - std::floor(a / b) * b; });
}
int less(lua_State* L) {
  return map_two(L, [](double a, double b) { return a < b ? 1.0 : 0.0; });
}
int less_equal(lua_State* L) {
  return map_two(L, [](double a, double b) { return a <= b ? 1.0 : 0.0; });
}
int greater(lua_State* L) {
  return map_two(L, [](double a, double b) { return a > b ? 1.0 : 0.0; });
}
int greater_equal(lua_State* L) {
  return map_two(L, [](double a, double b) { return a >= b ? 1.0 : 0.0; });
}
int equal(lua_State* L) {
  return map_two(L, [](double a, double b) { return a == b ? 1.0 : 0.0; });
}

int clamp(lua_State* L) {
  const Operand x = operand_argument(L, 1, "x");
  const Operand lower = operand_argument(L, 2, "lower");
  const Operand upper = operand_argument(L, 3, "upper");
  const auto limited = [](double v, double low, double high) { return v < low ? low : v > high ? high : v; };
  Array* result = push_common(L, {x, lower, upper});
  if (result == nullptr) {
    lua_pushnumber(L, limited(x.number, lower.number, upper.number));
    return 1;
  }
  for (std::int64_t i = 0; i < result->size(); ++i) result->data()[i] = limited(x[i], lower[i], upper[i]);
  return 1;
}

int where(lua_State* L) {
  const Operand condition = operand_argument(L, 1, "condition");
  const Operand a = operand_argument(L, 2, "a");
  const Operand b = operand_argument(L, 3, "b");
  Array* result = push_common(L, {condition, a, b});
  if (result == nullptr) {
    lua_pushnumber(L, condition.number != 0 ? a.number : b.number);
    return 1;
  }
  for (std::int64_t i = 0; i < result->size(); ++i) result->data()[i] = condition[i] != 0 ? a[i] : b[i];
  return 1;
}

Entry of_one(std::string_view name, lua_CFunction function, std::string_view doc) {
  return {name, function, "x: pl.Vector|number", "pl.Vector|number", doc, true};
}
Entry of_two(std::string_view name, lua_CFunction function, std::string_view doc) {
  return {name, function, "a: pl.Vector|number, b: pl.Vector|number", "pl.Vector|number", doc, true};
}

}  // namespace

Entries elementwise_functions() {
  return {
      of_one("sin", guarded<math<std::sin>>, "sine; angles in rad"),
      of_one("cos", guarded<math<std::cos>>, "cosine"),
      of_one("tan", guarded<math<std::tan>>, "tangent"),
      of_one("asin", guarded<math<std::asin>>, "arc sine, -pi/2 to pi/2"),
      of_one("acos", guarded<math<std::acos>>, "arc cosine, 0 to pi"),
      {"atan", guarded<arc_tangent>, "y: pl.Vector|number, x?: pl.Vector|number", "pl.Vector|number",
       "arc tangent; with two arguments the angle of the point (x, y)", true},
      of_one("sinh", guarded<math<std::sinh>>, "hyperbolic sine"),
      of_one("cosh", guarded<math<std::cosh>>, "hyperbolic cosine"),
      of_one("tanh", guarded<math<std::tanh>>, "hyperbolic tangent"),
      of_one("exp", guarded<math<std::exp>>, "exponential function"),
      of_one("log", guarded<math<std::log>>, "natural logarithm"),
      of_one("log10", guarded<math<std::log10>>, "logarithm to base 10"),
      of_one("sqrt", guarded<math<std::sqrt>>, "square root"),
      of_one("abs", guarded<math<std::fabs>>, "magnitude"),
      of_one("sign", guarded<math<sign>>, "-1, 0 or 1"),
      of_one("floor", guarded<math<std::floor>>, "the whole number below"),
      of_one("ceil", guarded<math<std::ceil>>, "the whole number above"),
      of_one("round", guarded<math<std::round>>, "the nearest whole number, halves away from zero"),
      of_two("mod", guarded<modulo>, "remainder of a / b with the sign of b"),
      of_two("less", guarded<less>, "1 where a < b, else 0"),
      of_two("less_equal", guarded<less_equal>, "1 where a <= b, else 0"),
      of_two("greater", guarded<greater>, "1 where a > b, else 0"),
      of_two("greater_equal", guarded<greater_equal>, "1 where a >= b, else 0"),
      of_two("equal", guarded<equal>, "1 where a = b, else 0"),
      {"clamp", guarded<clamp>, "x: pl.Vector|number, lower: pl.Vector|number, upper: pl.Vector|number",
       "pl.Vector|number", "x, but not below lower nor above upper", true},
      {"where", guarded<where>, "condition: pl.Vector|number, a: pl.Vector|number, b: pl.Vector|number",
       "pl.Vector|number", "a where the condition is not 0, else b", true},
  };
}

}  // namespace plantloop::lua
