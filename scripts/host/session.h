// What belongs to one run of a script: its limits, its place, and what it has said so far.

#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/files.h"
#include "engine/base/report.h"
#include "scripts/host/sandbox.h"

namespace plantloop::lua {

struct Session {
  Session(const ScriptOptions& given, std::string path);

  const ScriptOptions& options;
  std::string script;   // path as the user gave it
  std::string project;  // absolute
  Sandbox sandbox;
  std::string wrong_input;  // the last error that was an InputError, whole

  // Loads a text chunk onto the stack as a function; lua_load's status.
  int load(lua_State* L, std::string_view text, const std::string& path);
  // Lua shortens long names of chunks in messages; the name in full, and a text with all of them in full.
  std::string full_name(const std::string& shortened) const;
  std::string with_full_names(std::string text) const;

  // Notes and warnings, each text once.
  void tell(const Report& report);

  std::vector<std::string> arguments;  // of the command line

  // The path of a file to read: relative to the script's folder, or absolute below the project; no hidden files. An
  // argument of the command line that names a file may be read as it is, as the user chose it.
  FileResult readable(const std::string& path) const;
  // The path of a file to write: below the working directory, not hidden, not a program. Its folders are made.
  FileResult writable(const std::string& path) const;

 private:
  std::vector<std::pair<std::string, std::string>> chunks_;  // shortened and full names that differ
  std::set<std::string> told_;
};

// The session that a Lua state belongs to, in every coroutine.
inline Session& session_of(lua_State* L) { return **static_cast<Session**>(lua_getextraspace(L)); }

}  // namespace plantloop::lua
