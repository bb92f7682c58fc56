// Vectors and matrices of scripts: their numbers stand inside Lua's object, so that Lua's memory limit and garbage
// collection hold for them.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "scripts/host/stack.h"

namespace plantloop::lua {

inline constexpr const char* array_kind = "vector";

struct Array {
  std::int64_t rows = 0, columns = 1;  // a vector is one column
  bool is_matrix = false;
  bool is_frozen = false;  // a run's column, or a copy of a matrix's row: not to be assigned to

  std::int64_t size() const { return rows * columns; }
  // Column by column.
  double* data() { return reinterpret_cast<double*>(this + 1); }
  const double* data() const { return reinterpret_cast<const double*>(this + 1); }
  std::span<const double> values() const { return {data(), static_cast<std::size_t>(size())}; }
};
using MatrixView = Eigen::Map<Eigen::MatrixXd>;
using ConstMatrixView = Eigen::Map<const Eigen::MatrixXd>;
inline MatrixView matrix_view(Array& a) { return {a.data(), a.rows, a.columns}; }
inline ConstMatrixView matrix_view(const Array& a) { return {a.data(), a.rows, a.columns}; }

// What `#` gives: elements of a vector, rows of a matrix.
inline std::int64_t length(const Array& a) { return a.is_matrix ? a.rows : a.size(); }

// A new array on the stack, its numbers not set. Raises when it does not fit the memory limit.
Array& push_array(lua_State* L, std::int64_t rows, std::int64_t columns, bool is_matrix);
inline Array& push_vector(lua_State* L, std::int64_t size) { return push_array(L, size, 1, false); }
Array& push_vector(lua_State* L, std::span<const double> values);
// Shaped like another one.
inline Array& push_like(lua_State* L, const Array& a) { return push_array(L, a.rows, a.columns, a.is_matrix); }

// Null when something else stands there.
Array* test_array(lua_State* L, int index);
// The array at an index; a table of numbers becomes a vector, a table of such tables a matrix, a number a vector of
// one, in place.
Array& array_argument(lua_State* L, int index, std::string_view what);
// The same, but a matrix is an error.
Array& vector_argument(lua_State* L, int index, std::string_view what);
// The numbers as they are used outside of Lua.
std::vector<double> numbers_argument(lua_State* L, int index, std::string_view what);

// A number or an array.
struct Operand {
  Array* array = nullptr;  // null: a number
  double number = 0;
  double operator[](std::int64_t i) const { return array ? array->data()[i] : number; }
};
Operand operand_argument(lua_State* L, int index, std::string_view what);
// Pushes the result array for operands used element by element; null when all are numbers. Sizes must agree.
Array* push_common(lua_State* L, std::initializer_list<Operand> operands);

// "a vector of 5", "a matrix of 2 x 3"
std::string shape_text(const Array& a);
// "[1, 2, 3]", long ones cut: "[1, 2, 3, ..., 99, 100] (100 numbers)"
std::string short_text(const Array& a);

// Adds `count` elements' worth of work; raises at a limit.
void count_elements(lua_State* L, double count);

}  // namespace plantloop::lua
