// Names of chunks, notes told once, and where a script may read and write.

#include "scripts/host/session.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>

namespace plantloop::lua {
namespace fs = std::filesystem;
namespace {

bool has_hidden_part(const fs::path& path) {
  return std::any_of(path.begin(), path.end(), [](const fs::path& part) {
    const std::string name = part.string();
    return name.size() > 1 && name[0] == '.' && name != "..";
  });
}

// The path from a folder to a file below it, both resolved; empty when it is not below.
fs::path below(const fs::path& folder, const fs::path& path) {
  const fs::path relative = path.lexically_relative(folder);
  return relative.empty() || *relative.begin() == ".." ? fs::path() : relative;
}

// As the user would type it: relative to the working directory when it lies below.
std::string as_typed(const fs::path& path) {
  std::error_code error;
  const fs::path relative = below(fs::current_path(error), path);
  return (relative.empty() ? path : relative).string();
}

}  // namespace

Session::Session(const ScriptOptions& given, std::string path)
    : options(given), script(std::move(path)), project(project_folder(script)), sandbox(given) {}

int Session::load(lua_State* L, std::string_view text, const std::string& path) {
  if (text.starts_with("#")) {  // the line for a shell; its end stays, so that lines keep their numbers
    const std::size_t end = text.find('\n');
    text.remove_prefix(end == std::string_view::npos ? text.size() : end);
  }
  const int status = luaL_loadbufferx(L, text.data(), text.size(), ("@" + path).c_str(), "t");
  if (path.size() >= LUA_IDSIZE) {
    // As Lua does it: three dots and the end.
    constexpr std::size_t kept = LUA_IDSIZE - 4;
    chunks_.emplace_back("..." + path.substr(path.size() - kept), path);
  }
  return status;
}

std::string Session::full_name(const std::string& shortened) const {
  for (const auto& [name, full] : chunks_) {
    if (name == shortened) return full;
  }
  return shortened;
}

std::string Session::with_full_names(std::string text) const {
  for (const auto& [name, full] : chunks_) {
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + full.size())) {
      text.replace(at, name.size(), full);
    }
  }
  return text;
}

void Session::tell(const Report& report) {
  if (report.findings().empty()) return;
  const std::string text = to_text(report, options.colour);
  if (told_.insert(text).second) *options.messages << text << std::flush;
}

FileResult Session::readable(const std::string& path) const {
  // What the user named on the command line, alone or as in test=FILE, is his to show, wherever it lies; a folder or a
  // device is not read.
  std::error_code error;
  const auto names = [&path](const std::string& argument) {
    return argument == path || argument.substr(argument.find('=') + 1) == path;
  };
  if (std::any_of(arguments.begin(), arguments.end(), names) && fs::is_regular_file(path, error)) return {path, {}};
  FileResult result;
  fs::path rest = path;
  if (rest.is_absolute()) {
    rest = below(project, rest.lexically_normal());
    if (rest.empty()) return {{}, "it lies outside of the project; paths are relative to the script's folder"};
    result = resolve_path(project, (fs::path(project) / "script").string(), rest.string());
    if (result.ok()) result.value = as_typed(result.value);
  } else {
    result = resolve_path(project, script, path);
  }
  if (result.ok() && has_hidden_part(rest)) return {{}, "hidden files are not read"};
  return result;
}

FileResult Session::writable(const std::string& path) const {
  if (path.empty()) return {{}, "the path is empty"};
  if (path.find('\0') != std::string::npos) return {{}, "a path has no NUL"};
  std::error_code error;
  const fs::path here = fs::canonical(fs::current_path(error), error);
  if (error) return {{}, "the working directory is gone"};
  const fs::path real = fs::weakly_canonical(here / path, error);
  if (error) return {{}, error.message()};
  const fs::path relative = below(here, real);
  if (relative.empty() || relative == ".") return {{}, "a script writes only below the working directory"};
  if (has_hidden_part(relative)) return {{}, "hidden files and folders are not written"};
  struct stat status {};
  if (::stat(real.c_str(), &status) == 0) {
    if (S_ISDIR(status.st_mode)) return {{}, "it is a folder"};
    if (!S_ISREG(status.st_mode)) return {{}, "it is no regular file"};
    if ((status.st_mode & 0111U) != 0) return {{}, "it is a program, which a script does not replace"};
  }
  return {as_typed(real), {}};
}

}  // namespace plantloop::lua
