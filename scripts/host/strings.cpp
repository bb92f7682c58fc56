// The functions of `string`: Lua's where they take no time, ours where a short call could take forever.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "scripts/host/api.h"
#include "scripts/host/pattern.h"
#include "scripts/host/session.h"

namespace plantloop::lua {
namespace {

// Without dump, which makes bytecode.
constexpr std::array names{"byte",     "char",    "format", "len",    "lower", "pack",
                           "packsize", "reverse", "sub",    "unpack", "upper"};

// The text at an index; numbers count as texts, as everywhere in Lua. The view lives as long as the argument.
std::string_view view(lua_State* L, int index, const char* what) {
  if (lua_isstring(L, index) == 0) {
    throw ScriptError(fmt::format("'{}' must be a text, it is {}", what, describe(L, index)));
  }
  std::size_t size = 0;
  const char* text = lua_tolstring(L, index, &size);
  return {text, size};
}

std::function<void(double)> counting(lua_State* L) {
  return [L](double steps) { session_of(L).sandbox.work(L, steps); };
}

int repeat(lua_State* L) {
  const std::string_view text = view(L, 1, "text");
  const lua_Integer count = luaL_checkinteger(L, 2);
  const std::string_view between = is_given(L, 3) ? view(L, 3, "separator") : std::string_view();
  if (count <= 0 || text.size() + between.size() == 0) {
    lua_pushliteral(L, "");
    return 1;
  }
  constexpr std::size_t most = std::size_t{1} << 40;
  const auto n = static_cast<std::size_t>(count);
  if (n > most / (text.size() + between.size())) {
    session_of(L).sandbox.exceed(Limit::memory);
    session_of(L).sandbox.check(L);
  }
  const std::size_t size = n * text.size() + (n - 1) * between.size();
  session_of(L).sandbox.work(L, static_cast<double>(size) / 16 + static_cast<double>(n) / 4);
  session_of(L).sandbox.make_room(L, 2 * size);
  luaL_Buffer buffer;
  char* const out = luaL_buffinitsize(L, &buffer, size);
  std::copy(text.begin(), text.end(), out);
  if (n > 1) std::copy(between.begin(), between.end(), out + text.size());
  // What stands there already is copied behind itself, twice as much each time.
  for (std::size_t done = text.size() + between.size(); done < size; done *= 2) {
    std::memcpy(out + done, out, std::min(done, size - done));
  }
  luaL_pushresultsize(&buffer, size);
  return 1;
}

// Pushes capture `index`, or the whole match when the pattern has none.
void push_capture(lua_State* L, const Pattern& pattern, int index, std::string_view subject, const char* start,
                  const char* end) {
  if (index >= pattern.captures()) {
    if (index != 0) throw ScriptError(fmt::format("the pattern has no capture %{}", index + 1));
    push_text(L, {start, static_cast<std::size_t>(end - start)});
    return;
  }
  const Capture& c = pattern.capture(index);
  if (c.length == Capture::position) {
    lua_pushinteger(L, c.start - subject.data() + 1);
  } else {
    push_text(L, {c.start, static_cast<std::size_t>(c.length)});
  }
}

int push_captures(lua_State* L, const Pattern& pattern, std::string_view subject, const char* start, const char* end,
                  bool whole_if_none) {
  const int count = pattern.captures() == 0 && whole_if_none ? 1 : pattern.captures();
  luaL_checkstack(L, count, "too many captures");
  for (int i = 0; i < count; ++i) push_capture(L, pattern, i, subject, start, end);
  return count;
}

// Where a search begins, from 0; beyond the end when there is nothing to search.
std::size_t search_start(lua_State* L, int index, std::size_t size) {
  const lua_Integer at = is_given(L, index) ? luaL_checkinteger(L, index) : 1;
  if (at > 0) return static_cast<std::size_t>(at) - 1;
  if (at == 0 || at < -static_cast<lua_Integer>(size)) return 0;
  return size - static_cast<std::size_t>(-at);
}

int search(lua_State* L, bool is_find) {
  const std::string_view subject = view(L, 1, "text");
  const std::string_view text = view(L, 2, "pattern");
  const std::size_t at = search_start(L, 3, subject.size());
  if (at > subject.size()) {
    lua_pushnil(L);
    return 1;
  }
  if (is_find && (lua_toboolean(L, 4) != 0 || text.find_first_of("^$*+?.([%-") == std::string_view::npos)) {
    std::size_t found = std::string_view::npos;
    // In pieces of at most some 10^8 comparisons, so that the clock is asked now and then.
    const std::size_t piece =
        std::clamp((std::size_t{1} << 27) / (text.size() + 1), std::size_t{1}, std::size_t{1} << 16);
    for (std::size_t begin = at; begin <= subject.size() && found == std::string_view::npos; begin += piece) {
      found = subject.substr(begin, piece + text.size()).find(text);
      if (found != std::string_view::npos) found += begin;
      session_of(L).sandbox.work(L, static_cast<double>(piece) * static_cast<double>(text.size() + 1) / 64 + 1);
    }
    if (found == std::string_view::npos) {
      lua_pushnil(L);
      return 1;
    }
    lua_pushinteger(L, static_cast<lua_Integer>(found) + 1);
    lua_pushinteger(L, static_cast<lua_Integer>(found + text.size()));
    return 2;
  }
  Pattern pattern(subject, text, counting(L));
  const char* start = pattern.find_from(subject.data() + at);
  if (start == nullptr) {
    lua_pushnil(L);
    return 1;
  }
  const char* end = pattern.last_end();
  if (!is_find) return push_captures(L, pattern, subject, start, end, true);
  lua_pushinteger(L, start - subject.data() + 1);
  lua_pushinteger(L, end - subject.data());
  return 2 + push_captures(L, pattern, subject, start, end, false);
}

int find(lua_State* L) { return search(L, true); }
int match(lua_State* L) { return search(L, false); }

// Upvalues: the text, the pattern, where to go on, and the end of the last match (-1: none).
int next_match(lua_State* L) {
  const std::string_view subject = view(L, lua_upvalueindex(1), "text");
  Pattern pattern(subject, view(L, lua_upvalueindex(2), "pattern"), counting(L));
  const lua_Integer last = lua_tointeger(L, lua_upvalueindex(4));
  auto at = static_cast<std::size_t>(lua_tointeger(L, lua_upvalueindex(3)));
  while (at <= subject.size()) {
    const char* start = pattern.find_from(subject.data() + at);
    if (start == nullptr) return 0;
    const char* end = pattern.last_end();
    const lua_Integer end_at = end - subject.data();
    if (end_at != last) {
      lua_pushinteger(L, end_at);
      lua_copy(L, -1, lua_upvalueindex(3));
      lua_replace(L, lua_upvalueindex(4));
      return push_captures(L, pattern, subject, start, end, true);
    }
    if (pattern.is_anchored()) return 0;
    at = static_cast<std::size_t>(start - subject.data()) + 1;
  }
  return 0;
}

int all_matches(lua_State* L) {
  const std::string_view subject = view(L, 1, "text");
  view(L, 2, "pattern");
  std::size_t at = search_start(L, 3, subject.size());
  if (at > subject.size()) at = subject.size() + 1;
  lua_settop(L, 2);
  lua_pushinteger(L, static_cast<lua_Integer>(at));
  lua_pushinteger(L, -1);
  lua_pushcclosure(L, guarded<next_match>, 4);
  return 1;
}

// The text that stands for a match, appended to the buffer. False when the match stays as it is.
void add_replacement(lua_State* L, luaL_Buffer& buffer, const Pattern& pattern, std::string_view subject,
                     const char* start, const char* end) {
  const int kind = lua_type(L, 3);
  if (kind == LUA_TSTRING || kind == LUA_TNUMBER) {
    const std::string_view text = view(L, 3, "replacement");
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] != '%') {
        luaL_addchar(&buffer, text[i]);
        continue;
      }
      const char what = ++i < text.size() ? text[i] : '\0';
      if (what == '%') {
        luaL_addchar(&buffer, '%');
      } else if (what == '0') {
        luaL_addlstring(&buffer, start, static_cast<std::size_t>(end - start));
      } else if (what >= '1' && what <= '9') {
        push_capture(L, pattern, what - '1', subject, start, end);
        luaL_tolstring(L, -1, nullptr);
        lua_remove(L, -2);
        luaL_addvalue(&buffer);
      } else {
        throw ScriptError("in the replacement '%' stands before a digit or another '%'");
      }
    }
    return;
  }
  if (kind == LUA_TFUNCTION) {
    lua_pushvalue(L, 3);
    lua_call(L, push_captures(L, pattern, subject, start, end, true), 1);
  } else {
    push_capture(L, pattern, 0, subject, start, end);
    lua_gettable(L, 3);
  }
  if (lua_toboolean(L, -1) == 0) {
    lua_pop(L, 1);
    push_text(L, {start, static_cast<std::size_t>(end - start)});
  } else if (lua_isstring(L, -1) == 0) {
    throw ScriptError(fmt::format("the replacement is {}, which is no text", describe(L, -1)));
  }
  luaL_addvalue(&buffer);
}

int replace(lua_State* L) {
  const std::string_view subject = view(L, 1, "text");
  const std::string_view text = view(L, 2, "pattern");
  const int kind = lua_type(L, 3);
  if (kind != LUA_TNUMBER && kind != LUA_TSTRING && kind != LUA_TTABLE && kind != LUA_TFUNCTION) {
    throw ScriptError(fmt::format("the replacement must be a text, a table or a function, it is {}", describe(L, 3)));
  }
  const lua_Integer most = is_given(L, 4) ? luaL_checkinteger(L, 4) : LUA_MAXINTEGER;
  lua_settop(L, 4);
  Pattern pattern(subject, text, counting(L));
  luaL_Buffer buffer;
  luaL_buffinit(L, &buffer);
  const char* at = subject.data();
  const char* const stop = at + subject.size();
  const char* last_end = nullptr;
  lua_Integer count = 0;
  while (count < most) {
    const char* end = pattern.match_at(at);
    if (end != nullptr && end != last_end) {
      ++count;
      add_replacement(L, buffer, pattern, subject, at, end);
      at = last_end = end;
    } else if (at < stop) {
      luaL_addchar(&buffer, *at);
      ++at;
    } else {
      break;
    }
    if (pattern.is_anchored()) break;
  }
  luaL_addlstring(&buffer, at, static_cast<std::size_t>(stop - at));
  luaL_pushresult(&buffer);
  lua_pushinteger(L, count);
  return 2;
}

}  // namespace

void open_strings(lua_State* L) {
  lua_pushcfunction(L, luaopen_string);  // also gives texts their metatable
  lua_call(L, 0, 1);
  for (const char* name : names) {
    lua_getfield(L, -1, name);
    lua_setfield(L, -3, name);
  }
  lua_pop(L, 1);
  const std::pair<const char*, lua_CFunction> functions[] = {{"find", guarded<find>},
                                                             {"gmatch", guarded<all_matches>},
                                                             {"gsub", guarded<replace>},
                                                             {"match", guarded<match>},
                                                             {"rep", guarded<repeat>}};
  for (const auto& [name, function] : functions) {
    lua_pushcfunction(L, function);
    lua_setfield(L, -2, name);
  }
  lua_pushliteral(L, "");
  lua_getmetatable(L, -1);
  lua_pushvalue(L, -3);
  lua_setfield(L, -2, "__index");
  lua_pushliteral(L, "text");
  lua_setfield(L, -2, "__metatable");
  lua_pop(L, 2);
}

}  // namespace plantloop::lua
