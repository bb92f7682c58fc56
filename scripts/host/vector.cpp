// Making arrays and reading them from arguments.

#include "scripts/host/vector.h"

#include <fmt/format.h>

#include <algorithm>

#include "scripts/host/session.h"

namespace plantloop::lua {
namespace {

// A table of numbers, or of equally long tables of numbers (rows), as a new array on the stack; an error otherwise.
Array& from_table(lua_State* L, int index, std::string_view what) {
  const lua_Integer count = luaL_len(L, index);
  if (count == 0 && (lua_pushnil(L), lua_next(L, index)) != 0) {
    throw ScriptError(fmt::format("'{}' must be a list of numbers, it is a table with names", what));
  }
  const bool is_matrix = count > 0 && (lua_rawgeti(L, index, 1) == LUA_TTABLE);
  const lua_Integer columns = is_matrix ? luaL_len(L, -1) : 1;
  if (count > 0) lua_pop(L, 1);
  Array& array = push_array(L, count, columns, is_matrix);
  const auto number = [&](lua_Integer row, lua_Integer column) {
    if (lua_type(L, -1) != LUA_TNUMBER) {
      const std::string at = is_matrix ? fmt::format("{}, {}", row, column) : fmt::format("{}", row);
      throw ScriptError(fmt::format("'{}' must be numbers, but element {} is {}", what, at, describe(L, -1)));
    }
    array.data()[row - 1 + (column - 1) * count] = lua_tonumber(L, -1);
    lua_pop(L, 1);
  };
  for (lua_Integer row = 1; row <= count; ++row) {
    lua_rawgeti(L, index, row);
    if (!is_matrix) {
      number(row, 1);
      continue;
    }
    if (!lua_istable(L, -1) || luaL_len(L, -1) != columns) {
      throw ScriptError(
          fmt::format("'{}' must have rows of equal length: row {} has not {} numbers", what, row, columns));
    }
    for (lua_Integer column = 1; column <= columns; ++column) {
      lua_rawgeti(L, -1, column);
      number(row, column);
    }
    lua_pop(L, 1);
  }
  return array;
}

}  // namespace

Array& push_array(lua_State* L, std::int64_t rows, std::int64_t columns, bool is_matrix) {
  constexpr double most = 1e12;
  const double size = static_cast<double>(rows) * static_cast<double>(columns);
  if (!(size < most)) session_of(L).sandbox.exceed(Limit::memory);
  count_elements(L, size);
  void* place = lua_newuserdatauv(L, sizeof(Array) + static_cast<std::size_t>(size) * sizeof(double), 1);
  auto* array = new (place) Array{.rows = rows, .columns = columns, .is_matrix = is_matrix};
  luaL_setmetatable(L, array_kind);
  return *array;
}

Array& push_vector(lua_State* L, std::span<const double> values) {
  Array& array = push_vector(L, static_cast<std::int64_t>(values.size()));
  std::copy(values.begin(), values.end(), array.data());
  return array;
}

Array* test_array(lua_State* L, int index) { return static_cast<Array*>(luaL_testudata(L, index, array_kind)); }

Array& array_argument(lua_State* L, int index, std::string_view what) {
  if (Array* array = test_array(L, index)) return *array;
  index = lua_absindex(L, index);
  if (lua_type(L, index) == LUA_TNUMBER) {
    const double value = lua_tonumber(L, index);
    push_vector(L, std::span(&value, 1));
  } else if (lua_istable(L, index)) {
    from_table(L, index, what);
  } else {
    throw ScriptError(fmt::format("'{}' must be a vector or a list of numbers, it is {}", what, describe(L, index)));
  }
  lua_replace(L, index);
  return *test_array(L, index);
}

Array& vector_argument(lua_State* L, int index, std::string_view what) {
  Array& array = array_argument(L, index, what);
  if (array.is_matrix && array.columns != 1 && array.rows != 1) {
    throw ScriptError(fmt::format("'{}' must be a vector, it is {}", what, shape_text(array)));
  }
  return array;
}

std::vector<double> numbers_argument(lua_State* L, int index, std::string_view what) {
  const Array& array = vector_argument(L, index, what);
  return {array.data(), array.data() + array.size()};
}

Operand operand_argument(lua_State* L, int index, std::string_view what) {
  if (lua_type(L, index) == LUA_TNUMBER) return {nullptr, lua_tonumber(L, index)};
  return {&array_argument(L, index, what), 0};
}

Array* push_common(lua_State* L, std::initializer_list<Operand> operands) {
  const Array* shape = nullptr;
  for (const Operand& operand : operands) {
    if (operand.array == nullptr) continue;
    if (shape == nullptr) shape = operand.array;
    if (operand.array->rows != shape->rows || operand.array->columns != shape->columns) {
      throw ScriptError(fmt::format("{} and {} do not go together element by element", shape_text(*shape),
                                    shape_text(*operand.array)));
    }
  }
  return shape == nullptr ? nullptr : &push_like(L, *shape);
}

std::string shape_text(const Array& a) {
  return a.is_matrix ? fmt::format("a matrix of {} x {}", a.rows, a.columns) : fmt::format("a vector of {}", a.rows);
}

std::string short_text(const Array& a) {
  constexpr std::int64_t all = 10;
  const auto list = [](std::int64_t size, const auto& at) {
    std::string text = "[";
    for (std::int64_t i = 0; i < size; ++i) {
      if (size > all && i == 3) {
        text += ", ...";
        i = size - 2;
      }
      text += fmt::format("{}{:.6g}", i > 0 ? ", " : "", at(i));
    }
    return text + "]";
  };
  if (!a.is_matrix) {
    return list(a.rows, [&](std::int64_t i) { return a.data()[i]; }) +
           (a.rows > all ? fmt::format(" ({} numbers)", a.rows) : "");
  }
  std::string text = "[";
  for (std::int64_t row = 0; row < a.rows; ++row) {
    if (a.rows > all && row == 3) {
      text += ",\n ...";
      row = a.rows - 2;
    }
    text += (row > 0 ? ",\n " : "") + list(a.columns, [&](std::int64_t i) { return a.data()[row + i * a.rows]; });
  }
  return text + "]" + (a.size() > all * all ? fmt::format(" ({} x {})", a.rows, a.columns) : "");
}

void count_elements(lua_State* L, double count) { session_of(L).sandbox.work(L, 1 + count / 4); }

}  // namespace plantloop::lua
