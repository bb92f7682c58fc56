// Functions on the order of elements: sums along, differences, interpolation, search.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "scripts/host/api.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

int cumulative_sum(lua_State* L) {
  const Array& x = vector_argument(L, 1, "x");
  Array& result = push_vector(L, x.size());
  double total = 0;
  for (std::int64_t i = 0; i < x.size(); ++i) result.data()[i] = total += x.data()[i];
  return 1;
}

int difference(lua_State* L) {
  const Array& x = vector_argument(L, 1, "x");
  Array& result = push_vector(L, std::max<std::int64_t>(x.size() - 1, 0));
  for (std::int64_t i = 0; i < result.size(); ++i) result.data()[i] = x.data()[i + 1] - x.data()[i];
  return 1;
}

// Both vectors, of equal length.
std::pair<const Array*, const Array*> pair_argument(lua_State* L) {
  const Array& x = vector_argument(L, 1, "x");
  const Array& y = vector_argument(L, 2, "y");
  if (x.size() != y.size()) throw ScriptError(fmt::format("x has {} numbers and y has {}", x.size(), y.size()));
  count_elements(L, static_cast<double>(x.size()));
  return {&x, &y};
}

int integral(lua_State* L) {
  const auto [x, y] = pair_argument(L);
  double total = 0;
  for (std::int64_t i = 1; i < x->size(); ++i) {
    total += (x->data()[i] - x->data()[i - 1]) * (y->data()[i] + y->data()[i - 1]) / 2;
  }
  lua_pushnumber(L, total);
  return 1;
}

int running_integral(lua_State* L) {
  const auto [x, y] = pair_argument(L);
  Array& result = push_vector(L, x->size());
  double total = 0;
  for (std::int64_t i = 0; i < x->size(); ++i) {
    if (i > 0) total += (x->data()[i] - x->data()[i - 1]) * (y->data()[i] + y->data()[i - 1]) / 2;
    result.data()[i] = total;
  }
  return 1;
}

// Straight lines between points with ascending x; at a jump (equal x) the right side.
double interpolate(const Array& x, const Array& y, double at, const std::string& outside) {
  const double* const begin = x.data();
  const double* const end = begin + x.size();
  if (std::isnan(at)) return at;
  if (at < *begin || at > end[-1]) {
    if (outside == "error") {
      throw ScriptError(
          fmt::format("{:g} lies outside of {:g} to {:g}; {{outside = \"clip\"}} holds the last value, "
                      "{{outside = \"linear\"}} goes on straight",
                      at, *begin, end[-1]));
    }
    if (outside == "clip") return at < *begin ? *y.data() : y.data()[y.size() - 1];
  }
  const double* after = std::upper_bound(begin, end, at);
  if (after == end && outside != "linear") return y.data()[y.size() - 1];
  after = std::clamp(after, begin + 1, end - 1);
  const std::int64_t i = after - begin;
  const double width = x.data()[i] - x.data()[i - 1];
  if (width == 0) return y.data()[i];
  return y.data()[i - 1] + (at - x.data()[i - 1]) / width * (y.data()[i] - y.data()[i - 1]);
}

int interp1(lua_State* L) {
  const auto [x, y] = pair_argument(L);
  const Operand at = operand_argument(L, 3, "at");
  const Options options(L, 4, "the options of interp1", {"outside"});
  const std::string outside = options.text("outside", "error");
  if (outside != "error" && outside != "clip" && outside != "linear") options.wrong("outside", "error, clip or linear");
  if (x->size() < 2) throw ScriptError("it needs at least two points");
  if (!std::is_sorted(x->data(), x->data() + x->size())) throw ScriptError("'x' must not descend");
  Array* result = push_common(L, {at});
  if (result == nullptr) {
    lua_pushnumber(L, interpolate(*x, *y, at.number, outside));
    return 1;
  }
  count_elements(L, 8 * static_cast<double>(result->size()));
  for (std::int64_t i = 0; i < result->size(); ++i) result->data()[i] = interpolate(*x, *y, at[i], outside);
  return 1;
}

int find(lua_State* L) {
  const Array& condition = vector_argument(L, 1, "condition");
  std::int64_t count = 0;
  for (const double v : condition.values()) count += v != 0 ? 1 : 0;
  double* out = push_vector(L, count).data();
  for (std::int64_t i = 0; i < condition.size(); ++i) {
    if (condition.data()[i] != 0) *out++ = static_cast<double>(i + 1);
  }
  return 1;
}

int select(lua_State* L) {
  const Array& x = vector_argument(L, 1, "x");
  const Array& at = vector_argument(L, 2, "elements");
  Array& result = push_vector(L, at.size());
  for (std::int64_t i = 0; i < at.size(); ++i) {
    const double k = at.data()[i];
    if (k != std::floor(k) || !(k >= 1 && k <= static_cast<double>(x.size()))) {
      throw ScriptError(fmt::format("there is no element {:g}: the vector has elements 1 to {}", k, x.size()));
    }
    result.data()[i] = x.data()[static_cast<std::int64_t>(k) - 1];
  }
  return 1;
}

int sort(lua_State* L) {
  const Array& x = vector_argument(L, 1, "x");
  Array& result = push_vector(L, x.values());
  count_elements(L, 20 * static_cast<double>(x.size()));
  // Not-a-numbers stand last.
  std::stable_sort(result.data(), result.data() + result.size(),
                   [](double a, double b) { return std::isnan(b) ? !std::isnan(a) : a < b; });
  return 1;
}

int reverse(lua_State* L) {
  const Array& x = vector_argument(L, 1, "x");
  Array& result = push_vector(L, x.values());
  std::reverse(result.data(), result.data() + result.size());
  return 1;
}

}  // namespace

Entries series_functions() {
  return {
      {"cumsum", guarded<cumulative_sum>, "x: pl.Vector", "pl.Vector", "the sums of the first 1, 2, ... elements",
       true},
      {"diff", guarded<difference>, "x: pl.Vector", "pl.Vector", "what each element adds to the one before", true},
      {"trapz", guarded<integral>, "x: pl.Vector, y: pl.Vector", "number",
       "the integral of y over x along straight lines"},
      {"cumtrapz", guarded<running_integral>, "x: pl.Vector, y: pl.Vector", "pl.Vector",
       "the integral of y from the first x to each x"},
      {"interp1", guarded<interp1>,
       "x: pl.Vector, y: pl.Vector, at: pl.Vector|number, options?: {outside: \"error\"|\"clip\"|\"linear\"}",
       "pl.Vector|number", "y on straight lines between the points (x, y); x must not descend"},
      {"find", guarded<find>, "condition: pl.Vector", "pl.Vector", "where the elements stand that are not 0", true},
      {"select", guarded<select>, "x: pl.Vector, elements: pl.Vector", "pl.Vector",
       "the elements with these numbers, as `find` gives them", true},
      {"sort", guarded<sort>, "x: pl.Vector", "pl.Vector", "the elements, ascending", true},
      {"reverse", guarded<reverse>, "x: pl.Vector", "pl.Vector", "the elements, last first", true},
  };
}

}  // namespace plantloop::lua
