// `require`: the module "plantloop", and modules written in Lua that stand in the project.

#include <fmt/format.h>

#include <filesystem>

#include "engine/base/text.h"
#include "scripts/host/api.h"
#include "scripts/host/session.h"

namespace plantloop::lua {
namespace {

namespace fs = std::filesystem;

// "tools.fit" -> "tools/fit.lua"; empty when the name is none.
std::string file_of(const std::string& name) {
  std::string path;
  std::size_t begin = 0;
  while (begin <= name.size()) {
    const std::size_t end = std::min(name.find('.', begin), name.size());
    const std::string part = name.substr(begin, end - begin);
    if (!is_identifier(part)) return {};
    path += (begin > 0 ? "/" : "") + part;
    begin = end + 1;
  }
  return path + ".lua";
}

// Upvalue 1: the modules that are loaded, by name; `false` while one is loading.
int require(lua_State* L) {
  const std::string name = text_argument(L, 1, "name");
  Session& session = session_of(L);
  lua_settop(L, 1);
  lua_pushvalue(L, 1);
  const int known = lua_rawget(L, lua_upvalueindex(1));
  if (known == LUA_TBOOLEAN && lua_toboolean(L, -1) == 0) {
    throw ScriptError(fmt::format("module '{}' needs itself", name));
  }
  if (known != LUA_TNIL) return 1;
  lua_pop(L, 1);

  const std::string file = file_of(name);
  if (file.empty()) throw ScriptError(fmt::format("'{}' is no name of a module", name));
  constexpr std::size_t most = std::size_t{4} << 20;
  std::string tried;
  for (const std::string& path : {file, session.project + "/scripts/lib/" + file}) {
    const FileResult place = session.readable(path);
    if (!place.ok()) continue;
    std::error_code error;
    if (!fs::exists(place.value, error)) {
      tried += (tried.empty() ? "" : " and ") + place.value;
      continue;
    }
    const FileResult text = read_file(place.value, most);
    if (!text.ok()) throw ScriptError(fmt::format("cannot read '{}': {}", place.value, text.error));
    if (session.load(L, text.value, place.value) != LUA_OK) throw ScriptError(lua_tostring(L, -1));
    lua_pushvalue(L, 1);
    lua_pushboolean(L, 0);
    lua_rawset(L, lua_upvalueindex(1));
    lua_pushvalue(L, 1);
    lua_call(L, 1, 1);
    if (lua_isnil(L, -1)) {
      lua_pop(L, 1);
      lua_pushboolean(L, 1);
    }
    lua_pushvalue(L, 1);
    lua_pushvalue(L, -2);
    lua_rawset(L, lua_upvalueindex(1));
    return 1;
  }
  throw ScriptError(fmt::format("there is no module '{}': no file {}", name, tried));
}

}  // namespace

void open_require(lua_State* L) {
  lua_newtable(L);
  push_module(L);
  lua_setfield(L, -2, "plantloop");
  lua_pushcclosure(L, guarded<require>, 1);
  lua_setfield(L, -2, "require");
}

}  // namespace plantloop::lua
