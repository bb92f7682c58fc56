// Arguments, options and errors, in the user's words.

#include "scripts/host/stack.h"

#include <fmt/format.h>

#include <cmath>
#include <new>

#include "engine/base/error.h"
#include "engine/base/report.h"
#include "identify/fit_report.h"
#include "scripts/host/session.h"

namespace plantloop::lua {

void push_error(lua_State* L, const std::exception& e) {
  Session& session = session_of(L);
  if (dynamic_cast<const std::bad_alloc*>(&e)) session.sandbox.exceed(Limit::memory);
  if (dynamic_cast<const LimitError*>(&e)) session.sandbox.look_around();
  // A fit looks at the same clock and the same wish to stop, from all of its threads.
  if (dynamic_cast<const identify::Cancelled*>(&e) != nullptr) {
    session.sandbox.look_around();
    session.sandbox.exceed(Limit::time);  // unless something else was found
  }
  if (session.sandbox.exceeded() != Limit::none) {
    session.sandbox.push_end(L);
    return;
  }
  std::string text = e.what();
  lua_Debug frame;
  if (dynamic_cast<const ScriptError*>(&e) != nullptr && lua_getstack(L, 0, &frame) != 0 &&
      lua_getinfo(L, "n", &frame) != 0 && frame.name != nullptr && std::string_view(frame.namewhat) != "metamethod") {
    text = fmt::format("{}: {}", frame.name, text);
  }
  luaL_where(L, 1);
  const bool is_input = dynamic_cast<const InputError*>(&e) != nullptr;
  if (is_input) lua_pushliteral(L, "this diagram cannot be run\n");
  push_text(L, text);
  lua_concat(L, is_input ? 3 : 2);
  if (is_input) session.wrong_input = lua_tostring(L, -1);
}

std::string describe(lua_State* L, int index) {
  switch (lua_type(L, index)) {
    case LUA_TNONE:
    case LUA_TNIL:
      return "nothing (nil)";
    case LUA_TBOOLEAN:
      return lua_toboolean(L, index) ? "true" : "false";
    case LUA_TNUMBER: {
      const double value = lua_tonumber(L, index);
      return fmt::format("{:.14g}", value);
    }
    case LUA_TSTRING: {
      std::size_t size = 0;
      lua_pushvalue(L, index);
      const char* text = lua_tolstring(L, -1, &size);
      const std::string shown = size > 40 ? std::string(text, 37) + "..." : std::string(text, size);
      lua_pop(L, 1);
      return fmt::format("the text '{}'", shown);
    }
    case LUA_TUSERDATA: {
      if (luaL_getmetafield(L, index, "__name") == LUA_TSTRING) {
        std::string name = lua_tostring(L, -1);
        lua_pop(L, 1);
        return "a " + name;
      }
      return "an object";
    }
    default:
      return std::string("a ") + luaL_typename(L, index);
  }
}

double number_argument(lua_State* L, int index, std::string_view what) {
  if (lua_type(L, index) != LUA_TNUMBER) {
    throw ScriptError(fmt::format("'{}' must be a number, it is {}", what, describe(L, index)));
  }
  return lua_tonumber(L, index);
}

std::int64_t integer_argument(lua_State* L, int index, std::string_view what, std::int64_t least, std::int64_t most) {
  const double value = number_argument(L, index, what);
  if (value != std::floor(value) || !(value >= static_cast<double>(least) && value <= static_cast<double>(most))) {
    throw ScriptError(
        fmt::format("'{}' must be a whole number from {} to {}, it is {}", what, least, most, describe(L, index)));
  }
  return static_cast<std::int64_t>(value);
}

std::string text_argument(lua_State* L, int index, std::string_view what) {
  if (lua_type(L, index) != LUA_TSTRING) {
    throw ScriptError(fmt::format("'{}' must be a text, it is {}", what, describe(L, index)));
  }
  std::size_t size = 0;
  const char* text = lua_tolstring(L, index, &size);
  return {text, size};
}

bool is_given(lua_State* L, int index) { return !lua_isnoneornil(L, index); }

void table_argument(lua_State* L, int index, std::string_view what) {
  if (!lua_istable(L, index)) {
    throw ScriptError(fmt::format("'{}' must be a table, it is {}", what, describe(L, index)));
  }
}

void push_text(lua_State* L, std::string_view text) { lua_pushlstring(L, text.data(), text.size()); }

std::string suggestion(std::string_view text, const std::vector<std::string>& candidates) {
  constexpr std::size_t most = 30;
  std::string list;
  for (std::size_t i = 0; i < candidates.size() && i < most; ++i) list += (i ? ", " : "") + candidates[i];
  if (candidates.size() > most) list += ", ...";
  const std::string near = nearest(text, candidates);
  return (near.empty() ? "" : fmt::format("; did you mean '{}'?", near)) +
         (list.empty() ? "" : fmt::format("{} it has: {}", near.empty() ? ";" : " ", list));
}

Options::Options(lua_State* L, int index, std::string_view what, std::vector<std::string> known) : L_(L), index_(0) {
  if (!is_given(L, index)) return;
  table_argument(L, index, what);
  index_ = lua_absindex(L, index);
  lua_pushnil(L);
  while (lua_next(L, index_) != 0) {
    lua_pop(L, 1);
    if (lua_type(L, -1) != LUA_TSTRING) {
      throw ScriptError(
          fmt::format("{} are named, as in {{{} = ...}}; here is {}", what, known.front(), describe(L, -1)));
    }
    const std::string key = lua_tostring(L, -1);
    bool found = false;
    for (const std::string& name : known) found = found || name == key;
    if (!found) throw ScriptError(fmt::format("{}: there is no '{}'{}", what, key, suggestion(key, known)));
  }
}

bool Options::push(const char* key) const {
  if (index_ == 0) return false;
  if (lua_getfield(L_, index_, key) != LUA_TNIL) return true;
  lua_pop(L_, 1);
  return false;
}

bool Options::has(const char* key) const {
  if (!push(key)) return false;
  lua_pop(L_, 1);
  return true;
}

void Options::wrong(const char* key, const char* wanted) const {
  push(key);
  throw ScriptError(fmt::format("'{}' must be {}, it is {}", key, wanted, describe(L_, -1)));
}

std::optional<double> Options::number(const char* key) const {
  if (!push(key)) return std::nullopt;
  if (lua_type(L_, -1) != LUA_TNUMBER) wrong(key, "a number");
  const double value = lua_tonumber(L_, -1);
  lua_pop(L_, 1);
  return value;
}

std::string Options::text(const char* key, std::string_view fallback) const {
  if (!push(key)) return std::string(fallback);
  if (lua_type(L_, -1) != LUA_TSTRING) wrong(key, "a text");
  std::size_t size = 0;
  const char* text = lua_tolstring(L_, -1, &size);
  std::string result(text, size);
  lua_pop(L_, 1);
  return result;
}

bool Options::flag(const char* key) const {
  if (!push(key)) return false;
  if (!lua_isboolean(L_, -1)) wrong(key, "true or false");
  const bool value = lua_toboolean(L_, -1) != 0;
  lua_pop(L_, 1);
  return value;
}

void check_self(lua_State* L, int index, const char* kind) {
  if (luaL_testudata(L, index, kind) != nullptr) return;
  throw ScriptError(
      fmt::format("it is called with ':' on a {}, as in x:method(...); here is {}", kind, describe(L, index)));
}

}  // namespace plantloop::lua
