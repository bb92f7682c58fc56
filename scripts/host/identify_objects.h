// What scripts hold of identification: objects with fields and methods, their memory counted as the script's.

#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "identify/data/data_set.h"
#include "identify/fit_report.h"
#include "identify/linear/state_space.h"
#include "scripts/host/api.h"
#include "scripts/host/session.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {

inline constexpr const char* data_kind = "data set";

// Immutable. `bytes` count against the script's memory while the object lives.
template <typename T>
struct Held {
  std::shared_ptr<const T> value;
  std::size_t bytes = 0;
};

template <typename T>
void push_held(lua_State* L, const char* kind, T value, std::size_t bytes) {
  session_of(L).sandbox.hold(L, bytes);
  push_object(L, kind, Held<T>{std::make_shared<const T>(std::move(value)), bytes});
}
template <typename T>
int destroy_held(lua_State* L) {
  auto* held = static_cast<Held<T>*>(lua_touserdata(L, 1));
  session_of(L).sandbox.release(held->bytes);
  held->~Held<T>();
  return 0;
}
template <typename T>
const T& held_argument(lua_State* L, int index, const char* kind, std::string_view what) {
  const auto* held = test_object<Held<T>>(L, index, kind);
  if (held == nullptr) throw ScriptError(fmt::format("'{}' must be a {}, it is {}", what, kind, describe(L, index)));
  return *held->value;
}
template <typename T>
const T& held_self(lua_State* L, const char* kind) {
  return *self_argument<Held<T>>(L, kind).value;
}

// A field of an object, read as object.name.
template <typename T>
struct Field {
  std::string_view name, type, doc;
  void (*push)(lua_State* L, const T& object);
};

template <typename T>
std::vector<FieldInfo> infos_of(const std::vector<Field<T>>& fields) {
  std::vector<FieldInfo> infos;
  for (const Field<T>& f : fields) infos.push_back({f.name, f.type, f.doc});
  return infos;
}

// Upvalues: the methods, and the fields, a static list.
template <typename T>
int held_index(lua_State* L) {
  const auto& fields = *static_cast<const std::vector<Field<T>>*>(lua_touserdata(L, lua_upvalueindex(2)));
  const T& object = *static_cast<Held<T>*>(lua_touserdata(L, 1))->value;
  const std::string name = text_argument(L, 2, "name");
  if (lua_getfield(L, lua_upvalueindex(1), name.c_str()) != LUA_TNIL) return 1;
  std::vector<std::string> names;
  for (const Field<T>& field : fields) {
    if (field.name == name) {
      field.push(L, object);
      return 1;
    }
    names.emplace_back(field.name);
  }
  lua_pushnil(L);
  while (lua_next(L, lua_upvalueindex(1)) != 0) {
    lua_pop(L, 1);
    names.emplace_back(lua_tostring(L, -1));
  }
  std::sort(names.begin(), names.end());
  throw ScriptError(
      fmt::format("a {} has no '{}'{}", lua_tostring(L, lua_upvalueindex(3)), name, suggestion(name, names)));
}

template <typename T>
void open_held(lua_State* L, const char* kind, const Entries& methods, const std::vector<Field<T>>& fields) {
  luaL_newmetatable(L, kind);
  lua_pushcfunction(L, destroy_held<T>);
  lua_setfield(L, -2, "__gc");
  push_text(L, kind);
  lua_setfield(L, -2, "__metatable");
  push_functions(L, methods);
  lua_pushlightuserdata(L, const_cast<std::vector<Field<T>>*>(&fields));
  push_text(L, kind);
  lua_pushcclosure(L, guarded<held_index<T>>, 3);
  lua_setfield(L, -2, "__index");
  lua_pop(L, 1);
}

// Values of C++ onto the stack.
void push_numbers(lua_State* L, const Eigen::VectorXd& x);
void push_matrix(lua_State* L, const Eigen::MatrixXd& m);
// A vector when there is one column, else a matrix.
void push_columns(lua_State* L, const Eigen::MatrixXd& m);
// Of each experiment samples x outputs: below each other.
void push_outputs(lua_State* L, const std::vector<Eigen::MatrixXd>& parts);
// Measured less predicted, as the predictions stand.
void push_residuals(lua_State* L, const identify::DataSet& data, std::vector<Eigen::MatrixXd> predictions);
void push_texts(lua_State* L, const std::vector<std::string>& texts);
// {method = ..., reached = ..., tried = {...}, ..., text = "..."}
void push_report(lua_State* L, const identify::FitReport& report);

// Values of scripts.
Eigen::VectorXd vector_of(lua_State* L, int index, std::string_view what);
Eigen::MatrixXd matrix_of(lua_State* L, int index, std::string_view what);
// An option that is one whole number or a list of them; empty when it is not given.
std::vector<int> integers(lua_State* L, const Options& options, const char* key);
int integer(const Options& options, const char* key, int fallback);
// How many first samples an estimated start may use: "samples", or all.
inline Eigen::Index start_samples(const Options& o) {
  if (!o.has("samples")) return std::numeric_limits<Eigen::Index>::max();
  const int samples = integer(o, "samples", 0);
  if (samples < 1) throw ScriptError("'samples' must be 1 or more");
  return samples;
}
// How a free run begins: "start", estimated or zero.
identify::StateStart start_of(const Options& o);
// The same of a model of regressors at `index`: "start", measured or zero; true for zero.
bool starts_at_zero(lua_State* L, int index);
std::vector<std::string> texts(lua_State* L, const Options& options, const char* key);

// Ends a fit when a limit of the script is passed.
identify::FitControl control_of(lua_State* L);

void push_data(lua_State* L, identify::DataSet data);
const identify::DataSet& data_argument(lua_State* L, int index);

// Writes a text file below the working directory, and pushes its path; the name must end in one of `endings`.
void write_and_push(lua_State* L, const std::string& path, std::string_view text,
                    std::initializer_list<const char*> endings);
// The text of a file of the project.
std::string read_text(lua_State* L, const std::string& path);

}  // namespace plantloop::lua
