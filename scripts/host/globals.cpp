// The globals of a script: a new table with what is on the list, and nothing that is not.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "scripts/host/api.h"
#include "scripts/host/session.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

// Lua's own functions that neither run long nor reach outside. What is missing here is left out or stands below.
constexpr std::array base_names{"assert",   "error",    "getmetatable", "next",   "pcall",
                                "rawequal", "rawget",   "rawlen",       "rawset", "select",
                                "xpcall",   "tonumber", "tostring",     "type",   "_VERSION"};
constexpr std::array coroutine_names{"create", "isyieldable", "resume", "running", "status", "yield"};
constexpr std::array utf8_names{"char", "charpattern", "codepoint", "codes", "len", "offset"};
constexpr std::array math_names{"abs", "acos",       "asin", "atan",      "ceil", "cos",    "deg",
                                "exp", "floor",      "fmod", "huge",      "log",  "max",    "maxinteger",
                                "min", "mininteger", "modf", "pi",        "rad",  "random", "randomseed",
                                "sin", "sqrt",       "tan",  "tointeger", "type", "ult"};

int print(lua_State* L) {
  std::ostream& out = *session_of(L).options.output;
  if (session_of(L).options.progress) session_of(L).options.progress("", 1);
  const int count = lua_gettop(L);
  for (int i = 1; i <= count; ++i) {
    std::size_t size = 0;
    const char* text = luaL_tolstring(L, i, &size);
    if (i > 1) out << '\t';
    out.write(text, static_cast<std::streamsize>(size));
    lua_pop(L, 1);
  }
  out << '\n' << std::flush;
  session_of(L).sandbox.work(L, 20);
  if (!out) throw ScriptError("nobody reads what is printed");
  return 0;
}

// Lua runs finalizers without its hook, so an endless one could not be stopped.
int set_metatable(lua_State* L) {
  table_argument(L, 1, "table");
  if (is_given(L, 2)) {
    table_argument(L, 2, "metatable");
    lua_pushliteral(L, "__gc");
    if (lua_rawget(L, 2) != LUA_TNIL) throw ScriptError("finalizers (__gc) are not available to experiments");
    lua_pop(L, 1);
  }
  if (luaL_getmetafield(L, 1, "__metatable") != LUA_TNIL) throw ScriptError("this metatable is protected");
  lua_settop(L, 2);
  lua_setmetatable(L, 1);
  return 1;
}

int next_element(lua_State* L) {
  const lua_Integer i = lua_tointeger(L, 2) + 1;
  if (const Array* array = test_array(L, 1); array != nullptr && i > length(*array)) return 0;
  lua_pushinteger(L, i);
  return lua_geti(L, 1, i) == LUA_TNIL ? 1 : 2;
}

int ipairs(lua_State* L) {
  if (!is_given(L, 1)) throw ScriptError(fmt::format("there is {} to go through", describe(L, 1)));
  lua_pushcfunction(L, guarded<next_element>);
  lua_pushvalue(L, 1);
  lua_pushinteger(L, 0);
  return 3;
}

struct Key {
  int kind;  // order of kinds: numbers, texts, others
  double number;
  std::string text;
  lua_Integer place;  // in the table of keys
};

// The next key of the sorted ones that still has a value. Upvalue: the keys; the state counts in them.
int next_sorted(lua_State* L) {
  for (lua_Integer i = lua_tointeger(L, lua_upvalueindex(2)) + 1;; ++i) {
    lua_pushinteger(L, i);
    lua_replace(L, lua_upvalueindex(2));
    lua_settop(L, 1);
    if (lua_rawgeti(L, lua_upvalueindex(1), i) == LUA_TNIL) return 1;
    lua_pushvalue(L, 2);
    if (lua_rawget(L, 1) != LUA_TNIL) return 2;
  }
}

// Lua's own order of keys differs from run to run; an experiment gives the same result every time.
int sorted_pairs(lua_State* L) {
  luaL_checkany(L, 1);
  if (luaL_getmetafield(L, 1, "__pairs") != LUA_TNIL) {
    lua_pushvalue(L, 1);
    lua_call(L, 1, 3);
    return 3;
  }
  if (test_array(L, 1) != nullptr) return ipairs(L);
  table_argument(L, 1, "table");
  std::vector<Key> keys;
  lua_settop(L, 1);
  lua_newtable(L);  // in the order of `next`
  lua_pushnil(L);
  while (lua_next(L, 1) != 0) {
    lua_pop(L, 1);
    Key key{2, 0, {}, static_cast<lua_Integer>(keys.size()) + 1};
    if (lua_type(L, -1) == LUA_TNUMBER) {
      key.kind = 0;
      key.number = lua_tonumber(L, -1);
    } else if (lua_type(L, -1) == LUA_TSTRING) {
      std::size_t size = 0;
      const char* text = lua_tolstring(L, -1, &size);
      key.kind = 1;
      key.text.assign(text, size);
    }
    lua_pushvalue(L, -1);
    lua_rawseti(L, 2, key.place);
    keys.push_back(std::move(key));
  }
  session_of(L).sandbox.work(L, 10 * static_cast<double>(keys.size()));
  const auto less = [](const Key& a, const Key& b) {
    return a.kind != b.kind ? a.kind < b.kind : a.kind == 0 ? a.number < b.number : a.text < b.text;
  };
  if (!std::is_sorted(keys.begin(), keys.end(), less)) std::stable_sort(keys.begin(), keys.end(), less);
  lua_createtable(L, static_cast<int>(keys.size()), 0);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    lua_rawgeti(L, 2, keys[i].place);
    lua_rawseti(L, -2, static_cast<lua_Integer>(i) + 1);
  }
  lua_pushinteger(L, 0);
  lua_pushcclosure(L, next_sorted, 2);
  lua_pushvalue(L, 1);
  lua_pushnil(L);
  return 3;
}

// Lua runs message handlers, and what is pending in a coroutine that failed, where the error was raised: without a hook
// when the hook raised it. So once the script must end, neither is run. (The three functions below follow Lua's own.)
bool must_end(lua_State* L) { return session_of(L).sandbox.exceeded() != Limit::none; }

// Upvalue 1: the script's handler.
int handle(lua_State* L) {
  if (must_end(L)) return 1;
  lua_settop(L, 1);
  lua_pushvalue(L, lua_upvalueindex(1));
  lua_insert(L, 1);
  lua_call(L, 1, 1);
  return 1;
}

int finish_xpcall(lua_State* L, int status, lua_KContext) {
  if (status == LUA_OK || status == LUA_YIELD) return lua_gettop(L) - 2;
  lua_pushboolean(L, 0);
  lua_pushvalue(L, -2);
  return 2;
}

int xpcall(lua_State* L) {
  const int count = lua_gettop(L);
  luaL_checktype(L, 2, LUA_TFUNCTION);
  lua_pushvalue(L, 2);
  lua_pushcclosure(L, handle, 1);
  lua_replace(L, 2);
  lua_pushboolean(L, 1);
  lua_pushvalue(L, 1);
  lua_rotate(L, 3, 2);
  return finish_xpcall(L, lua_pcallk(L, count - 2, LUA_MULTRET, 2, 0, finish_xpcall), 0);
}

// Upvalue 1: the coroutine.
int wrapped(lua_State* L) {
  lua_State* const co = lua_tothread(L, lua_upvalueindex(1));
  const int count = lua_gettop(L);
  int results = 0;
  int status = LUA_ERRRUN;
  if (lua_status(co) == LUA_OK && lua_gettop(co) == 0) {
    lua_pushliteral(L, "cannot resume dead coroutine");
  } else {
    if (lua_checkstack(co, count) == 0) return luaL_error(L, "too many arguments to resume");
    lua_xmove(L, co, count);
    status = lua_resume(co, L, count, &results);
    if (status == LUA_OK || status == LUA_YIELD) {
      if (lua_checkstack(L, results + 1) == 0) return luaL_error(L, "too many results to resume");
      lua_xmove(co, L, results);
      return results;
    }
    session_of(L).sandbox.check(L);
    if (status != LUA_OK && status != LUA_YIELD) {
      status = lua_resetthread(co);
      lua_xmove(co, L, 1);
    }
  }
  if (status != LUA_ERRMEM && lua_type(L, -1) == LUA_TSTRING) {
    luaL_where(L, 1);
    lua_insert(L, -2);
    lua_concat(L, 2);
  }
  return lua_error(L);
}

int wrap(lua_State* L) {
  luaL_checktype(L, 1, LUA_TFUNCTION);
  lua_State* const co = lua_newthread(L);
  lua_pushvalue(L, 1);
  lua_xmove(L, co, 1);
  lua_pushcclosure(L, wrapped, 1);
  return 1;
}

int close(lua_State* L) {
  lua_State* const co = lua_tothread(L, 1);
  if (co == nullptr) throw ScriptError(fmt::format("'coroutine' must be one, it is {}", describe(L, 1)));
  session_of(L).sandbox.check(L);
  // Only a coroutine that is suspended or dead is at rest.
  lua_Debug frame;
  const bool suspended = lua_status(co) == LUA_YIELD;
  const bool dead_or_new = lua_status(co) != LUA_OK || lua_getstack(co, 0, &frame) == 0;
  if (co == L || !(suspended || dead_or_new)) throw ScriptError("a running coroutine cannot be closed");
  const int status = lua_resetthread(co);
  lua_pushboolean(L, status == LUA_OK ? 1 : 0);
  if (status == LUA_OK) return 1;
  lua_xmove(co, L, 1);
  return 2;
}

// Copies the named functions of the library that `open` makes into the table on the stack.
template <typename Names>
void take(lua_State* L, lua_CFunction open, const Names& names) {
  lua_pushcfunction(L, open);
  lua_call(L, 0, 1);
  for (const char* name : names) {
    lua_getfield(L, -1, name);
    lua_setfield(L, -3, name);
  }
  lua_pop(L, 1);
}

template <typename Names>
void take_library(lua_State* L, const char* library, lua_CFunction open, const Names& names) {
  lua_newtable(L);
  take(L, open, names);
  lua_setfield(L, -2, library);
}

}  // namespace

void open_globals(lua_State* L) {
  lua_newtable(L);
  take(L, luaopen_base, base_names);
  take_library(L, "coroutine", luaopen_coroutine, coroutine_names);
  lua_getfield(L, -1, "coroutine");
  lua_pushcfunction(L, wrap);
  lua_setfield(L, -2, "wrap");
  lua_pushcfunction(L, guarded<close>);
  lua_setfield(L, -2, "close");
  lua_pop(L, 1);
  take_library(L, "utf8", luaopen_utf8, utf8_names);
  take_library(L, "math", luaopen_math, math_names);
  // A fixed seed: the same script gives the same numbers.
  lua_getfield(L, -1, "math");
  lua_getfield(L, -1, "randomseed");
  lua_pushinteger(L, 1);
  lua_call(L, 1, 0);
  lua_pop(L, 1);

  const std::pair<const char*, lua_CFunction> own[] = {{"print", guarded<print>},
                                                       {"setmetatable", guarded<set_metatable>},
                                                       {"ipairs", guarded<ipairs>},
                                                       {"pairs", guarded<sorted_pairs>},
                                                       {"xpcall", xpcall}};
  for (const auto& [name, function] : own) {
    lua_pushcfunction(L, function);
    lua_setfield(L, -2, name);
  }
  lua_newtable(L);
  open_strings(L);
  lua_setfield(L, -2, "string");
  lua_newtable(L);
  open_tables(L);
  lua_setfield(L, -2, "table");
  open_require(L);

  lua_pushvalue(L, -1);
  lua_setfield(L, -2, "_G");
  lua_rawseti(L, LUA_REGISTRYINDEX, LUA_RIDX_GLOBALS);
}

}  // namespace plantloop::lua
