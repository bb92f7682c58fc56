// The door to Lua: its headers, and how our functions read their arguments and report what is wrong with them.
//
// Debian's Lua for C++ raises errors as exceptions, so destructors run when an error passes a C++ function. Its
// functions have the names of C in one release and those of C++ in the next; lua.h knows, lua.hpp would say C.

#pragma once

#include <lua.h>

#include <lauxlib.h>
#include <lualib.h>

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace plantloop::lua {

// The script used a function wrongly. Becomes an error of the script, at the line that called the function.
struct ScriptError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A diagram or a setting is wrong; the text is the whole of the findings. Ends the program with status 2 if not caught.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Leaves the message for an exception on the stack, with the script's position and the function's name.
void push_error(lua_State* L, const std::exception& e);

// Lua's view of one of our functions: what it throws becomes an error of the script.
template <int (*function)(lua_State*)>
int guarded(lua_State* L) {
  try {
    return function(L);
  } catch (const std::exception& e) {
    push_error(L, e);
  }
  return lua_error(L);
}

// "a number", "nothing", "a text", "a vector": what stands at an index, in the user's words.
std::string describe(lua_State* L, int index);

// Arguments of a function. `what` names them in messages: "'from' must be a number, it is a text".
double number_argument(lua_State* L, int index, std::string_view what);
std::int64_t integer_argument(lua_State* L, int index, std::string_view what, std::int64_t least, std::int64_t most);
std::string text_argument(lua_State* L, int index, std::string_view what);
bool is_given(lua_State* L, int index);
void table_argument(lua_State* L, int index, std::string_view what);

void push_text(lua_State* L, std::string_view text);

// A table of named options, {label = "y", width = 2}; nothing at the index is an empty one. Unknown names are errors
// with the nearest known one. Each value is looked up when it is asked for.
class Options {
 public:
  Options(lua_State* L, int index, std::string_view what, std::vector<std::string> known);
  bool has(const char* key) const;
  std::optional<double> number(const char* key) const;
  std::string text(const char* key, std::string_view fallback = {}) const;
  bool flag(const char* key) const;
  bool push(const char* key) const;  // the value onto the stack when there is one
  // "width must be a number, it is a text"
  [[noreturn]] void wrong(const char* key, const char* wanted) const;

 private:
  lua_State* L_;
  int index_;  // absolute; 0: no table
};

// "; did you mean 'y'? there are: r, u, y"
std::string suggestion(std::string_view text, const std::vector<std::string>& candidates);

// Objects of C++ in Lua. `kind` names the type in messages ("run") and keys its metatable.
template <typename T>
T& push_object(lua_State* L, const char* kind, T value) {
  void* place = lua_newuserdatauv(L, sizeof(T), 1);
  T* object = new (place) T(std::move(value));
  luaL_setmetatable(L, kind);
  return *object;
}
template <typename T>
int destroy_object(lua_State* L) {
  static_cast<T*>(lua_touserdata(L, 1))->~T();
  return 0;
}
template <typename T>
T* test_object(lua_State* L, int index, const char* kind) {
  return static_cast<T*>(luaL_testudata(L, index, kind));
}
// The object that a method was called on; says to call it with ':' when there is none.
void check_self(lua_State* L, int index, const char* kind);
template <typename T>
T& self_argument(lua_State* L, const char* kind) {
  check_self(L, 1, kind);
  return *static_cast<T*>(lua_touserdata(L, 1));
}

}  // namespace plantloop::lua
