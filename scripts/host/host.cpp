// From a path to an exit status: one Lua state per script, made, run under protection, and closed.

#include "scripts/host/host.h"

#include <fmt/format.h>

#include <memory>

#include "engine/base/files.h"
#include "scripts/host/api.h"
#include "scripts/host/session.h"

namespace plantloop {
namespace lua {
namespace {

struct Job {
  std::string_view text;
  const std::vector<std::string>& arguments;
  int load_status = LUA_OK;
};

// Where the script was: the calls that led to the error, in the user's files only. A message without a place, as of
// error(text, 0), is meant for readers who do not know the script, and is left alone.
std::string trace(lua_State* L, std::string_view message) {
  constexpr int most = 12;
  std::string text;
  int shown = 0;
  bool has_place = false;
  lua_Debug frame;
  for (int level = 1; lua_getstack(L, level, &frame) != 0; ++level) {
    lua_getinfo(L, "Sln", &frame);
    if (frame.currentline <= 0) continue;
    has_place = has_place || message.starts_with(fmt::format("{}:{}:", frame.short_src, frame.currentline));
    if (++shown == 1) continue;  // the message begins with it
    if (shown > most) {
      if (shown == most + 1) text += "\n  ...";
      continue;
    }
    text += fmt::format("\n  called from {}:{}", frame.short_src, frame.currentline);
    if (frame.name != nullptr && std::string_view(frame.what) == "Lua") text += fmt::format(" in '{}'", frame.name);
  }
  return has_place ? text : "";
}

// What scripts of other hosts look for.
std::string missing_library(std::string_view message) {
  for (const std::string_view name : {"io", "os", "debug", "package", "load", "loadstring", "dofile", "loadfile"}) {
    if (message.find(fmt::format("(global '{}')", name)) == std::string_view::npos) continue;
    return fmt::format("\n  '{}' is not available to experiments; pl.read, pl.write, pl.clock and require are", name);
  }
  return {};
}

// The message handler: the error as text, with its trace. Stays out of the way once the script must end.
int to_message(lua_State* L) {
  Session& session = session_of(L);
  if (session.sandbox.exceeded() != Limit::none) return 1;
  std::string text;
  if (lua_type(L, 1) == LUA_TSTRING || luaL_getmetafield(L, 1, "__tostring") != LUA_TNIL) {
    std::size_t size = 0;
    const char* shown = luaL_tolstring(L, 1, &size);
    text.assign(shown, size);
  } else {
    text = fmt::format("the error is {}, which has no text", describe(L, 1));
  }
  if (text == session.wrong_input) {  // the findings say where; the script's line stands in them
    push_text(L, text);
    return 1;
  }
  push_text(L, text + missing_library(text) + trace(L, text));
  return 1;
}

int set_up(lua_State* L) {
  open_vectors(L);
  open_diagrams(L);
  open_runs(L);
  open_figures(L);
  open_data(L);
  open_linear_models(L);
  open_models(L);
  open_learned_models(L);
  open_neural_state_space(L);
  open_globals(L);
  return 0;
}

// Runs protected: with the Job at 1.
int execute(lua_State* L) {
  Job& job = *static_cast<Job*>(lua_touserdata(L, 1));
  Session& session = session_of(L);
  set_up(L);
  lua_newtable(L);
  push_text(L, session.script);
  lua_rawseti(L, -2, 0);
  for (std::size_t i = 0; i < job.arguments.size(); ++i) {
    push_text(L, job.arguments[i]);
    lua_rawseti(L, -2, static_cast<lua_Integer>(i) + 1);
  }
  lua_setglobal(L, "arg");
  job.load_status = session.load(L, job.text, session.script);
  if (job.load_status != LUA_OK) return lua_error(L);
  for (const std::string& argument : job.arguments) {
    luaL_checkstack(L, 1, "arguments");
    push_text(L, argument);
  }
  session.sandbox.watch(L);
  lua_call(L, static_cast<int>(job.arguments.size()), 0);
  return 0;
}

int run(Session& session, Job& job) {
  struct Close {
    void operator()(lua_State* L) const { lua_close(L); }
  };
  std::ostream& messages = *session.options.messages;
  const std::unique_ptr<lua_State, Close> state(lua_newstate(Sandbox::allocate, &session.sandbox));
  if (!state) {
    messages << "there is no memory for the script" << std::endl;
    return script_failed;
  }
  lua_State* const L = state.get();
  *static_cast<Session**>(lua_getextraspace(L)) = &session;
  lua_pushcfunction(L, to_message);
  lua_pushcfunction(L, execute);
  lua_pushlightuserdata(L, &job);
  const int status = lua_pcall(L, 1, 0, 1);
  lua_sethook(L, nullptr, 0, 0);
  session.options.output->flush();
  // Lua's own buffers give up at the first refusal.
  const bool no_memory =
      status == LUA_ERRMEM || (status != LUA_OK && lua_type(L, -1) == LUA_TSTRING &&
                               std::string_view(lua_tostring(L, -1)).starts_with("not enough memory"));
  if (no_memory) session.sandbox.exceed(Limit::memory);
  if (session.sandbox.exceeded() != Limit::none) {
    messages << session.sandbox.why_it_ended() << std::endl;
    return script_failed;
  }
  if (status == LUA_OK) return script_done;
  std::size_t size = 0;
  const char* text = lua_type(L, -1) == LUA_TSTRING ? lua_tolstring(L, -1, &size) : nullptr;
  std::string message = text != nullptr ? std::string(text, size) : "the script failed without a message";
  const bool is_input = job.load_status != LUA_OK || (text != nullptr && message == session.wrong_input);
  message = session.with_full_names(std::move(message));
  messages << message << (message.ends_with('\n') ? "" : "\n") << std::flush;
  return is_input ? script_input_wrong : script_failed;
}

}  // namespace
}  // namespace lua

int run_script_text(std::string_view text, const std::string& path, const std::vector<std::string>& arguments,
                    const ScriptOptions& options) {
  lua::Session session(options, path);
  session.arguments = arguments;
  lua::Job job{text, arguments};
  return lua::run(session, job);
}

int run_script(const std::string& path, const std::vector<std::string>& arguments, const ScriptOptions& options) {
  constexpr std::size_t most = std::size_t{16} << 20;
  const FileResult file = read_file(path, most);
  if (!file.ok()) {
    *options.messages << fmt::format("cannot read '{}': {}", path, file.error) << std::endl;
    return script_input_wrong;
  }
  return run_script_text(file.value, path, arguments, options);
}

}  // namespace plantloop
