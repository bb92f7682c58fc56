// Functions of `pl` for files, time and notes.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "engine/base/csv.h"
#include "scripts/host/api.h"
#include "scripts/host/session.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

std::string content(lua_State* L, const std::string& path) {
  const Session& session = session_of(L);
  const FileResult place = session.readable(path);
  FileResult file = place.ok() ? read_file(place.value, session.sandbox.bytes_left() / 4) : place;
  if (!file.ok()) throw ScriptError(fmt::format("cannot read '{}': {}", path, file.error));
  return std::move(file.value);
}

int read(lua_State* L) {
  push_text(L, content(L, text_argument(L, 1, "path")));
  return 1;
}

int read_csv_file(lua_State* L) {
  const std::string path = text_argument(L, 1, "path");
  const CsvResult file = read_csv(content(L, path));
  if (!file.ok()) throw ScriptError(fmt::format("{}:{}:{}: {}", path, file.line, file.column, file.error));
  lua_createtable(L, 0, static_cast<int>(file.table.names.size()));
  for (std::size_t i = 0; i < file.table.names.size(); ++i) {
    push_text(L, file.table.names[i]);
    push_vector(L, file.table.columns[i]);
    lua_rawset(L, -3);
  }
  return 1;
}

int write(lua_State* L) {
  // Texts and data, nothing that is run.
  constexpr std::array endings{".txt", ".md", ".csv", ".tsv", ".dat", ".json", ".yaml", ".tex", ".html", ".svg"};
  const std::string path = text_argument(L, 1, "path");
  if (lua_isstring(L, 2) == 0) throw ScriptError(fmt::format("'text' must be a text, it is {}", describe(L, 2)));
  std::size_t size = 0;
  const char* text = lua_tolstring(L, 2, &size);
  const std::string ending = std::filesystem::path(path).extension().string();
  if (std::find(endings.begin(), endings.end(), ending) == endings.end()) {
    throw ScriptError(fmt::format("cannot write '{}': the name must end in one of {}", path, fmt::join(endings, " ")));
  }
  const FileResult place = session_of(L).writable(path);
  const std::string error = place.ok() ? write_file(place.value, {text, size}) : place.error;
  if (!error.empty()) throw ScriptError(fmt::format("cannot write '{}': {}", path, error));
  push_text(L, place.value);
  return 1;
}

int clock(lua_State* L) {
  lua_pushnumber(L, session_of(L).sandbox.elapsed());
  return 1;
}

int warn(lua_State* L) {
  *session_of(L).options.messages << text_argument(L, 1, "text") << std::endl;
  session_of(L).sandbox.work(L, 100);
  return 0;
}

}  // namespace

Entries file_functions() {
  return {
      {"read", guarded<read>, "path: string", "string", "the text of a file of the project"},
      {"read_csv", guarded<read_csv_file>, "path: string", "table<string, pl.Vector>",
       "the columns of a table of numbers in a file of the project, by name"},
      {"write", guarded<write>, "path: string, text: string", "string",
       "writes a text file below the working directory; gives its path"},
      {"clock", guarded<clock>, "", "number", "seconds since the script began"},
      {"warn", guarded<warn>, "text: string", "", "a line for the user on standard error"},
  };
}

}  // namespace plantloop::lua
