// How vectors behave in Lua: arithmetic, elements, comparison, text.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scripts/host/api.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

template <typename Operation>
int binary(lua_State* L, Operation operation) {
  const Operand a = operand_argument(L, 1, "the left operand");
  const Operand b = operand_argument(L, 2, "the right operand");
  Array* result = push_common(L, {a, b});
  for (std::int64_t i = 0, n = result->size(); i < n; ++i) result->data()[i] = operation(a[i], b[i]);
  return 1;
}

int add(lua_State* L) {
  return binary(L, [](double a, double b) { return a + b; });
}
int subtract(lua_State* L) {
  return binary(L, [](double a, double b) { return a - b; });
}
int multiply(lua_State* L) {
  return binary(L, [](double a, double b) { return a * b; });
}
int divide(lua_State* L) {
  return binary(L, [](double a, double b) { return a / b; });
}
int power(lua_State* L) {
  return binary(L, [](double a, double b) { return b == 2 ? a * a : std::pow(a, b); });
}
// The sign of the divisor, as in Lua and in diagrams.
int modulo(lua_State* L) {
  return binary(L, [](double a, double b) { return a - std::floor(a / b) * b; });
}

int negate(lua_State* L) {
  const Array& a = *test_array(L, 1);
  Array& result = push_like(L, a);
  std::transform(a.data(), a.data() + a.size(), result.data(), [](double x) { return -x; });
  return 1;
}

int count(lua_State* L) {
  lua_pushinteger(L, length(*test_array(L, 1)));
  return 1;
}

int is_equal(lua_State* L) {
  const Array* a = test_array(L, 1);
  const Array* b = test_array(L, 2);
  bool equal = a != nullptr && b != nullptr && a->rows == b->rows && a->columns == b->columns;
  if (equal) {
    count_elements(L, static_cast<double>(a->size()));
    equal = std::equal(a->data(), a->data() + a->size(), b->data());
  }
  lua_pushboolean(L, equal ? 1 : 0);
  return 1;
}

int not_in_order(lua_State* L) {
  (void)L;
  throw ScriptError("vectors are compared element by element by pl.less(a, b), pl.greater(a, b) and their like");
}

// The index that the user gave, from 1, as ours.
std::int64_t element(lua_State* L, int index, std::int64_t size, std::string_view of) {
  const double at = lua_tonumber(L, index);
  if (at != std::floor(at) || at < 1 || at > static_cast<double>(size)) {
    throw ScriptError(fmt::format("there is no element {:g}: {} has elements 1 to {}", at, of, size));
  }
  return static_cast<std::int64_t>(at) - 1;
}

// Upvalue 1: the methods.
int index(lua_State* L) {
  Array& a = *test_array(L, 1);
  if (lua_type(L, 2) == LUA_TNUMBER) {
    const std::int64_t i = element(L, 2, length(a), a.is_matrix ? "the matrix" : "the vector");
    if (!a.is_matrix) {
      lua_pushnumber(L, a.data()[i]);
      return 1;
    }
    Array& row = push_vector(L, a.columns);
    for (std::int64_t k = 0; k < a.columns; ++k) row.data()[k] = a.data()[i + k * a.rows];
    row.is_frozen = true;
    return 1;
  }
  lua_pushvalue(L, 2);
  if (lua_gettable(L, lua_upvalueindex(1)) != LUA_TNIL) return 1;
  if (lua_type(L, 2) != LUA_TSTRING) throw ScriptError(fmt::format("an element has a number, not {}", describe(L, 2)));
  std::vector<std::string> names;
  lua_pushnil(L);
  while (lua_next(L, lua_upvalueindex(1)) != 0) {
    lua_pop(L, 1);
    names.emplace_back(lua_tostring(L, -1));
  }
  std::sort(names.begin(), names.end());
  throw ScriptError(fmt::format("a vector has no '{}'{}", lua_tostring(L, 2), suggestion(lua_tostring(L, 2), names)));
}

int assign(lua_State* L) {
  Array& a = *test_array(L, 1);
  if (a.is_frozen) throw ScriptError("these numbers are fixed; x:copy() gives ones that may be changed");
  if (a.is_matrix) throw ScriptError("an element of a matrix is set by A:set(row, column, value)");
  if (lua_type(L, 2) != LUA_TNUMBER) throw ScriptError(fmt::format("an element has a number, not {}", describe(L, 2)));
  const std::int64_t i = element(L, 2, a.size(), "the vector");
  a.data()[i] = number_argument(L, 3, "the value");
  return 0;
}

// A(row, column), x(i); and the method of a run whose name is also a column: the vector carries it along.
int call(lua_State* L) {
  const Array& a = *test_array(L, 1);
  if (lua_getiuservalue(L, 1, 1) == LUA_TFUNCTION) {
    lua_replace(L, 1);
    lua_call(L, lua_gettop(L) - 1, LUA_MULTRET);
    return lua_gettop(L);
  }
  lua_pop(L, 1);
  number_argument(L, 2, a.is_matrix ? "row" : "element");
  if (!a.is_matrix) {
    lua_pushnumber(L, a.data()[element(L, 2, a.size(), "the vector")]);
    return 1;
  }
  number_argument(L, 3, "column");
  const std::int64_t row = element(L, 2, a.rows, "a column of the matrix");
  lua_pushnumber(L, a.data()[row + element(L, 3, a.columns, "a row of the matrix") * a.rows]);
  return 1;
}

int text(lua_State* L) {
  push_text(L, short_text(*test_array(L, 1)));
  return 1;
}

int join_texts(lua_State* L) {
  luaL_tolstring(L, 1, nullptr);
  luaL_tolstring(L, 2, nullptr);
  lua_concat(L, 2);
  return 1;
}

int set(lua_State* L) {
  Array& a = self_argument<Array>(L, array_kind);
  if (a.is_frozen) throw ScriptError("these numbers are fixed; x:copy() gives ones that may be changed");
  if (!a.is_matrix) throw ScriptError("an element of a vector is set by x[i] = value");
  number_argument(L, 2, "row");
  number_argument(L, 3, "column");
  const std::int64_t row = element(L, 2, a.rows, "a column of the matrix");
  const std::int64_t column = element(L, 3, a.columns, "a row of the matrix");
  a.data()[row + column * a.rows] = number_argument(L, 4, "value");
  return 0;
}

int slice(lua_State* L) {
  Array& a = self_argument<Array>(L, array_kind);
  const std::int64_t size = length(a);
  const std::int64_t first = integer_argument(L, 2, "first", 1, size + 1);
  const std::int64_t last = is_given(L, 3) ? integer_argument(L, 3, "last", first - 1, size) : size;
  const std::int64_t rows = last - first + 1;
  Array& result = a.is_matrix ? push_array(L, rows, a.columns, true) : push_vector(L, rows);
  for (std::int64_t k = 0; k < a.columns; ++k) {
    const double* from = a.data() + k * a.rows + first - 1;
    std::copy(from, from + rows, result.data() + k * rows);
  }
  return 1;
}

int copy(lua_State* L) {
  Array& a = self_argument<Array>(L, array_kind);
  Array& result = push_like(L, a);
  std::copy(a.data(), a.data() + a.size(), result.data());
  return 1;
}

int column(lua_State* L) {
  Array& a = self_argument<Array>(L, array_kind);
  const std::int64_t k = integer_argument(L, 2, "column", 1, a.columns) - 1;
  push_vector(L, std::span<const double>(a.data() + k * a.rows, static_cast<std::size_t>(a.rows)));
  return 1;
}

int rows(lua_State* L) {
  lua_pushinteger(L, self_argument<Array>(L, array_kind).rows);
  return 1;
}

int columns(lua_State* L) {
  lua_pushinteger(L, self_argument<Array>(L, array_kind).columns);
  return 1;
}

int to_table(lua_State* L) {
  const Array& a = self_argument<Array>(L, array_kind);
  count_elements(L, static_cast<double>(a.size()));
  const auto list = [L](std::int64_t size, const auto& at) {
    lua_createtable(L, static_cast<int>(std::min<std::int64_t>(size, 1 << 20)), 0);
    for (std::int64_t i = 0; i < size; ++i) {
      lua_pushnumber(L, at(i));
      lua_rawseti(L, -2, i + 1);
    }
  };
  if (!a.is_matrix) {
    list(a.size(), [&](std::int64_t i) { return a.data()[i]; });
    return 1;
  }
  lua_newtable(L);
  for (std::int64_t row = 0; row < a.rows; ++row) {
    list(a.columns, [&](std::int64_t i) { return a.data()[row + i * a.rows]; });
    lua_rawseti(L, -2, row + 1);
  }
  return 1;
}

}  // namespace

Entries vector_methods() {
  return {
      {"slice", guarded<slice>, "first: integer, last?: integer", "pl.Vector",
       "elements (of a matrix: rows) first to last, both included"},
      {"copy", guarded<copy>, "", "pl.Vector", "the same numbers, which may be changed"},
      {"set", guarded<set>, "row: integer, column: integer, value: number", "", "sets an element of a matrix"},
      {"column", guarded<column>, "column: integer", "pl.Vector", "a column of a matrix"},
      {"rows", guarded<rows>, "", "integer", "the number of rows; of a vector its length"},
      {"columns", guarded<columns>, "", "integer", "the number of columns; of a vector 1"},
      {"table", guarded<to_table>, "", "number[]", "a plain table of the numbers, of a matrix one for each row"},
  };
}

void open_vectors(lua_State* L) {
  luaL_newmetatable(L, array_kind);
  const std::pair<const char*, lua_CFunction> functions[] = {
      {"__add", guarded<add>},         {"__sub", guarded<subtract>},    {"__mul", guarded<multiply>},
      {"__div", guarded<divide>},      {"__pow", guarded<power>},       {"__mod", guarded<modulo>},
      {"__unm", guarded<negate>},      {"__len", guarded<count>},       {"__eq", guarded<is_equal>},
      {"__lt", guarded<not_in_order>}, {"__le", guarded<not_in_order>}, {"__newindex", guarded<assign>},
      {"__call", guarded<call>},       {"__tostring", guarded<text>},   {"__concat", guarded<join_texts>}};
  for (const auto& [name, function] : functions) {
    lua_pushcfunction(L, function);
    lua_setfield(L, -2, name);
  }
  lua_pushliteral(L, "vector");
  lua_setfield(L, -2, "__metatable");
  push_functions(L, vector_methods());
  for (const TypeInfo& type : api()) {
    if (type.name != "pl") continue;
    for (const Entry& entry : type.entries) {
      if (!entry.also_method) continue;
      lua_pushcfunction(L, entry.function);
      lua_setfield(L, -2, std::string(entry.name).c_str());
    }
  }
  lua_pushcclosure(L, guarded<index>, 1);
  lua_setfield(L, -2, "__index");
  lua_pop(L, 1);
}

}  // namespace plantloop::lua
