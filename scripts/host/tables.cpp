// The functions of `table`: Lua's, but each element counts as work, as a table can claim any length.

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "scripts/host/api.h"
#include "scripts/host/session.h"

namespace plantloop::lua {
namespace {

lua_Integer length_of(lua_State* L, int index) {
  if (!lua_istable(L, index) && luaL_getmetafield(L, index, "__len") == LUA_TNIL) {
    throw ScriptError(fmt::format("argument {} must be a table, it is {}", index, describe(L, index)));
  }
  return luaL_len(L, index);
}

// Counts the work on single elements; asks the clock every thousand.
class Work {
 public:
  explicit Work(lua_State* L) : L_(L) {}
  void one() {
    if (++count_ < 1000) return;
    session_of(L_).sandbox.work(L_, 3 * count_);
    count_ = 0;
  }

 private:
  lua_State* L_;
  double count_ = 0;
};

int insert(lua_State* L) {
  const lua_Integer end = length_of(L, 1) + 1;
  const int count = lua_gettop(L);
  if (count == 2) {
    lua_seti(L, 1, end);
    return 0;
  }
  if (count != 3) throw ScriptError("it takes a table, a position if need be, and a value");
  const lua_Integer at = integer_argument(L, 2, "position", 1, end);
  Work work(L);
  for (lua_Integer i = end; i > at; --i) {
    lua_geti(L, 1, i - 1);
    lua_seti(L, 1, i);
    work.one();
  }
  lua_seti(L, 1, at);
  return 0;
}

int remove(lua_State* L) {
  const lua_Integer size = length_of(L, 1);
  lua_Integer at = is_given(L, 2) ? integer_argument(L, 2, "position", size > 0 ? 1 : 0, size + 1) : size;
  lua_geti(L, 1, at);
  Work work(L);
  for (; at < size; ++at) {
    lua_geti(L, 1, at + 1);
    lua_seti(L, 1, at);
    work.one();
  }
  lua_pushnil(L);
  lua_seti(L, 1, at);
  return 1;
}

int concat(lua_State* L) {
  const std::string between = is_given(L, 2) ? text_argument(L, 2, "separator") : "";
  const lua_Integer first = is_given(L, 3) ? luaL_checkinteger(L, 3) : 1;
  const lua_Integer last = is_given(L, 4) ? luaL_checkinteger(L, 4) : length_of(L, 1);
  length_of(L, 1);
  lua_settop(L, 1);
  luaL_Buffer buffer;  // its memory is Lua's, hence limited
  luaL_buffinit(L, &buffer);
  Work work(L);
  for (lua_Integer i = first; i <= last; ++i) {
    if (i != first) luaL_addlstring(&buffer, between.data(), between.size());
    lua_geti(L, 1, i);
    if (lua_isstring(L, -1) == 0) {
      throw ScriptError(fmt::format("element {} is {}, which is no text", i, describe(L, -1)));
    }
    luaL_addvalue(&buffer);
    work.one();
    if (i == last) break;
  }
  luaL_pushresult(&buffer);
  return 1;
}

int pack(lua_State* L) {
  const int count = lua_gettop(L);
  lua_createtable(L, count, 1);
  lua_insert(L, 1);
  for (int i = count; i >= 1; --i) lua_seti(L, 1, i);
  lua_pushinteger(L, count);
  lua_setfield(L, 1, "n");
  return 1;
}

int unpack(lua_State* L) {
  const lua_Integer first = is_given(L, 2) ? luaL_checkinteger(L, 2) : 1;
  const lua_Integer last = is_given(L, 3) ? luaL_checkinteger(L, 3) : luaL_len(L, 1);
  if (first > last) return 0;
  const auto count = static_cast<lua_Unsigned>(last) - static_cast<lua_Unsigned>(first);
  constexpr lua_Unsigned most = 250;
  if (count >= most || lua_checkstack(L, static_cast<int>(count) + 1) == 0) {
    if (count >= 900'000 || lua_checkstack(L, static_cast<int>(count) + 1) == 0) {
      throw ScriptError("there are too many elements for a list of values");
    }
  }
  for (lua_Integer i = first; i < last; ++i) lua_geti(L, 1, i);
  lua_geti(L, 1, last);
  return static_cast<int>(count) + 1;
}

int move(lua_State* L) {
  const lua_Integer first = luaL_checkinteger(L, 2);
  const lua_Integer last = luaL_checkinteger(L, 3);
  const lua_Integer to = luaL_checkinteger(L, 4);
  const int into = is_given(L, 5) ? 5 : 1;
  length_of(L, 1);
  length_of(L, into);
  if (last >= first) {
    if (!(first > 0 || last < LUA_MAXINTEGER + first)) throw ScriptError("there are too many elements to move");
    const lua_Integer count = last - first + 1;
    if (to > LUA_MAXINTEGER - count + 1) throw ScriptError("the places after the last one are no numbers");
    Work work(L);
    const bool forward = to > last || to <= first || into != 1;
    for (lua_Integer k = 0; k < count; ++k) {
      const lua_Integer i = forward ? k : count - 1 - k;
      lua_geti(L, 1, first + i);
      lua_seti(L, into, to + i);
      work.one();
    }
  }
  lua_pushvalue(L, into);
  return 1;
}

// Merge sort on a copy: n log n comparisons whatever the comparator answers, and equal elements keep their order.
class Sort {
 public:
  explicit Sort(lua_State* L) : L_(L), has_order_(is_given(L, 2)), work_(L) {}

  // Tables 3 and 4 on the stack are the values and room for them.
  void operator()(lua_Integer count) {
    for (lua_Integer width = 1; width < count; width *= 2) {
      for (lua_Integer begin = 1; begin <= count; begin += 2 * width) {
        merge(begin, std::min(begin + width, count + 1), std::min(begin + 2 * width, count + 1));
      }
      lua_insert(L_, 3);  // 3 and 4 change places
    }
  }

 private:
  void merge(lua_Integer begin, lua_Integer middle, lua_Integer end) {
    lua_Integer a = begin;
    lua_Integer b = middle;
    for (lua_Integer k = begin; k < end; ++k) {
      const bool take_b = a >= middle || (b < end && less(b, a));
      lua_rawgeti(L_, 3, take_b ? b++ : a++);
      lua_rawseti(L_, 4, k);
      work_.one();
    }
  }

  bool less(lua_Integer i, lua_Integer j) {
    if (has_order_) lua_pushvalue(L_, 2);
    lua_rawgeti(L_, 3, i);
    lua_rawgeti(L_, 3, j);
    bool result = false;
    if (has_order_) {
      lua_call(L_, 2, 1);
      result = lua_toboolean(L_, -1) != 0;
      lua_pop(L_, 1);
    } else {
      result = lua_compare(L_, -2, -1, LUA_OPLT) != 0;
      lua_pop(L_, 2);
    }
    return result;
  }

  lua_State* L_;
  bool has_order_;
  Work work_;
};

int sort(lua_State* L) {
  const lua_Integer count = length_of(L, 1);
  if (is_given(L, 2) && !lua_isfunction(L, 2)) {
    throw ScriptError(fmt::format("the order must be a function, it is {}", describe(L, 2)));
  }
  lua_settop(L, 2);
  lua_newtable(L);
  lua_newtable(L);
  Work work(L);
  for (lua_Integer i = 1; i <= count; ++i) {
    if (lua_geti(L, 1, i) == LUA_TNIL) throw ScriptError(fmt::format("element {} of {} is nil", i, count));
    lua_rawseti(L, 3, i);
    work.one();
  }
  Sort{L}(count);
  for (lua_Integer i = 1; i <= count; ++i) {
    lua_rawgeti(L, 3, i);
    lua_seti(L, 1, i);
    work.one();
  }
  return 0;
}

}  // namespace

void open_tables(lua_State* L) {
  const std::pair<const char*, lua_CFunction> functions[] = {
      {"concat", guarded<concat>}, {"insert", guarded<insert>}, {"move", guarded<move>},    {"pack", guarded<pack>},
      {"remove", guarded<remove>}, {"sort", guarded<sort>},     {"unpack", guarded<unpack>}};
  for (const auto& [name, function] : functions) {
    lua_pushcfunction(L, function);
    lua_setfield(L, -2, name);
  }
}

}  // namespace plantloop::lua
