// pl.load, and what a diagram can do: run, check, carry other parameters.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "app/figures.h"
#include "engine/base/files.h"
#include "engine/base/numbers.h"
#include "engine/run/checkpoint.h"
#include "scripts/host/api.h"
#include "scripts/host/objects.h"
#include "scripts/host/session.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

// Warnings are told; errors end the call with the whole text.
void settle(Session& session, const Report& report, bool failed) {
  if (!failed && !report.has_errors()) return session.tell(report);
  throw InputError(to_text(report, session.options.colour));
}

int load(lua_State* L) {
  const std::string path = text_argument(L, 1, "path");
  Session& session = session_of(L);
  const FileResult place = session.readable(path);
  if (!place.ok()) throw ScriptError(fmt::format("cannot read '{}': {}", path, place.error));
  Report report;
  std::shared_ptr<Diagram> diagram = Diagram::load(place.value, report, plot_words());
  settle(session, report, diagram == nullptr);
  push_object(L, diagram_kind, DiagramObject{std::move(diagram), {}});
  return 1;
}

int diagram_from_text(lua_State* L) {
  const std::string text = text_argument(L, 1, "text");
  Session& session = session_of(L);
  const std::string path = (std::filesystem::path(session.script).parent_path() / "diagram in this script").string();
  Report report;
  std::shared_ptr<Diagram> diagram = Diagram::from_text(text, path, report, plot_words());
  settle(session, report, diagram == nullptr);
  push_object(L, diagram_kind, DiagramObject{std::move(diagram), {}});
  return 1;
}

// The value on top of the stack as a diagram would write it.
std::string expression_text(lua_State* L, const std::string& path) {
  if (lua_type(L, -1) == LUA_TNUMBER) {
    const double value = lua_tonumber(L, -1);
    if (value != value) throw ScriptError(fmt::format("'{}' is set to a value that is not a number", path));
    return shortest(value);
  }
  if (lua_type(L, -1) == LUA_TSTRING) return lua_tostring(L, -1);
  if (lua_isboolean(L, -1)) return lua_toboolean(L, -1) != 0 ? "true" : "false";
  const Array& a = array_argument(L, -1, path);
  const auto list = [](std::int64_t size, const auto& at) {
    std::string text = "[";
    for (std::int64_t i = 0; i < size; ++i) text += (i > 0 ? ", " : "") + at(i);
    return text + "]";
  };
  if (!a.is_matrix) return list(a.size(), [&](std::int64_t i) { return shortest(a.data()[i]); });
  return list(a.rows, [&](std::int64_t row) {
    return list(a.columns, [&](std::int64_t column) { return shortest(a.data()[row + column * a.rows]); });
  });
}

// {["controller.ki"] = 20, plant = {tau = 2}} at an index; sorted by path, as Lua's tables have no order.
void read_settings(lua_State* L, int index, const std::string& prefix, int depth, Overrides& set) {
  index = lua_absindex(L, index);
  constexpr int deepest = 50;
  if (depth > deepest) throw ScriptError("the table of settings contains itself");
  luaL_checkstack(L, 4, "settings");
  lua_pushnil(L);
  while (lua_next(L, index) != 0) {
    if (lua_type(L, -2) != LUA_TSTRING) {
      throw ScriptError(
          fmt::format("settings are named, as in set = {{[\"plant.tau\"] = 2}}; here is {}", describe(L, -2)));
    }
    const std::string path = prefix + lua_tostring(L, -2);
    if (lua_istable(L, -1) && luaL_len(L, -1) == 0) {
      read_settings(L, -1, path + ".", depth + 1, set);
    } else {
      set.push_back({path, expression_text(L, path)});
    }
    lua_pop(L, 1);
  }
  if (depth == 0) {
    std::sort(set.begin(), set.end(), [](const Override& a, const Override& b) { return a.path < b.path; });
  }
}

// The settings of `base` with those of the table at the index instead or in addition.
Overrides settings(lua_State* L, int index, const Overrides& base) {
  table_argument(L, index, "set");
  Overrides changed;
  read_settings(L, index, "", 0, changed);
  for (const Override& kept : base) {
    const bool replaced =
        std::any_of(changed.begin(), changed.end(), [&](const auto& o) { return o.path == kept.path; });
    if (!replaced) changed.push_back(kept);
  }
  std::sort(changed.begin(), changed.end(), [](const Override& a, const Override& b) { return a.path < b.path; });
  return changed;
}

RunRequest request_of(lua_State* L, int index, const Overrides& base) {
  const Options options(L, index, "the options of run",
                        {"set", "start", "stop", "step", "solver", "rtol", "atol", "max_step", "output_interval",
                         "save_at", "save", "from", "partial"});
  RunRequest request{.set = base};
  if (options.push("set")) {
    request.set = settings(L, -1, base);
    lua_pop(L, 1);
  }
  request.start = options.number("start");
  request.stop = options.number("stop");
  request.step = options.number("step");
  request.rtol = options.number("rtol");
  request.atol = options.number("atol");
  request.max_step = options.number("max_step");
  request.output_interval = options.number("output_interval");
  if (options.has("solver")) request.solver = options.text("solver");
  if (const auto save_at = options.number("save_at")) request.save_at = {*save_at};
  request.save_at_end = options.has("save") && request.save_at.empty();
  request.partial = options.flag("partial");
  return request;
}

// `from` and `save` are files: read inside the project, written below the working directory.
void prepare_checkpoints(lua_State* L, Session& session, RunControl& control) {
  if (!lua_istable(L, 2)) return;
  const auto path = [&](const char* key) -> std::string {
    lua_getfield(L, 2, key);
    std::string text = lua_isnil(L, -1) ? "" : text_argument(L, -1, key);
    lua_pop(L, 1);
    return text;
  };
  if (const std::string from = path("from"); !from.empty()) {
    const FileResult place = session.readable(from);
    const FileResult file = place.ok() ? read_file(place.value) : place;
    if (!file.ok()) throw ScriptError(fmt::format("cannot read '{}': {}", from, file.error));
    CheckpointResult read = checkpoint_from_json(file.value);
    if (!read.ok()) throw ScriptError(fmt::format("cannot read '{}': {}", from, read.error));
    control.from = std::make_shared<const Checkpoint>(std::move(read.checkpoint));
  }
  if (const std::string save = path("save"); !save.empty()) {
    const FileResult place = session.writable(save);
    if (!place.ok()) throw ScriptError(fmt::format("cannot save '{}': {}", save, place.error));
    control.save = [file = place.value, save](const Checkpoint& checkpoint) {
      const std::string error = write_file(file, to_json(checkpoint));
      if (!error.empty()) throw ScriptError(fmt::format("cannot save '{}': {}", save, error));
    };
  }
}

int run(lua_State* L) {
  DiagramObject& self = self_argument<DiagramObject>(L, diagram_kind);
  RunRequest request = request_of(L, 2, self.set);
  Session& session = session_of(L);
  RunControl control;
  control.cancel = session.options.cancel;
  if (session.options.time_limit > 0) control.time_limit = std::max(1e-3, session.sandbox.seconds_left());
  if (session.options.progress) {
    control.progress = [&](double fraction) { session.options.progress(self.diagram->model().path, fraction); };
  }
  prepare_checkpoints(L, session, control);
  session.sandbox.work(L, 1000);
  session.sandbox.tidy(L);
  request.max_memory = static_cast<double>(session.sandbox.bytes_left());
  Report report;
  std::optional<DiagramRun> result = self.diagram->run(request, report, control);
  session.sandbox.work(L, 1000);
  settle(session, report, !result);
  push_run(L, std::move(*result), self.diagram);
  return 1;
}

int check(lua_State* L) {
  DiagramObject& self = self_argument<DiagramObject>(L, diagram_kind);
  const Options options(L, 2, "the options of check", {"set"});
  Overrides set = self.set;
  if (options.push("set")) set = settings(L, -1, self.set);
  Report report;
  self.diagram->check(set, report);
  lua_pushboolean(L, report.has_errors() ? 0 : 1);
  push_text(L, to_text(report));
  return 2;
}

int with(lua_State* L) {
  DiagramObject& self = self_argument<DiagramObject>(L, diagram_kind);
  Overrides set = settings(L, 2, self.set);
  push_object(L, diagram_kind, DiagramObject{self.diagram, std::move(set)});
  return 1;
}

void push_parameters(lua_State* L, const DiagramObject& self) {
  lua_newtable(L);
  if (!self.diagram->model().top) return;
  for (const ParameterDecl& parameter : self.diagram->model().top->parameters) {
    std::string text = parameter.text.value_or("");
    if (parameter.value) text = to_string(*parameter.value);
    for (const Override& set : self.set) {
      if (set.path == parameter.name) text = set.text;
    }
    push_text(L, parameter.name);
    push_text(L, text);
    lua_rawset(L, -3);
  }
}

// Upvalue 1: the methods.
int index(lua_State* L) {
  const DiagramObject& self = *static_cast<DiagramObject*>(lua_touserdata(L, 1));
  const std::string name = text_argument(L, 2, "name");
  if (name == "title") {
    push_text(L, self.diagram->model().title);
  } else if (name == "path") {
    push_text(L, self.diagram->model().path);
  } else if (name == "parameters") {
    push_parameters(L, self);
  } else if (lua_getfield(L, lua_upvalueindex(1), name.c_str()) == LUA_TNIL) {
    throw ScriptError(
        fmt::format("a diagram has no '{}'{}", name,
                    suggestion(name, {"run", "check", "with", "linearise", "trim", "title", "path", "parameters"})));
  }
  return 1;
}

int text(lua_State* L) {
  const DiagramObject& self = *static_cast<DiagramObject*>(lua_touserdata(L, 1));
  push_text(L, fmt::format("the diagram {}", self.diagram->model().path));
  return 1;
}

}  // namespace

Entries diagram_functions() {
  return {
      {"load", guarded<load>, "path: string", "pl.Diagram",
       "reads a diagram file; the path is relative to the script's folder"},
      {"diagram", guarded<diagram_from_text>, "text: string", "pl.Diagram", "a diagram from its text"},
  };
}

Entries diagram_methods() {
  Entries methods{
      {"run", guarded<run>,
       "options?: {set?: table<string, number|string|pl.Vector>, start?: number, stop?: number, step?: number, "
       "solver?: string, rtol?: number, atol?: number, max_step?: number, output_interval?: number, save_at?: number, "
       "save?: string, from?: string, partial?: boolean}",
       "pl.Run",
       "simulates; what is not given is as the file says. `set` gives parameters other values or expressions"},
      {"check", guarded<check>, "options?: {set?: table<string, number|string|pl.Vector>}", "boolean, string",
       "everything but running: whether all is well, and the findings"},
      {"with", guarded<with>, "set: table<string, number|string|pl.Vector>", "pl.Diagram",
       "the same diagram with other values of parameters"},
  };
  for (const Entry& entry : analysis_methods()) methods.push_back(entry);
  for (const Entry& entry : velocity_methods()) methods.push_back(entry);
  return methods;
}

void open_diagrams(lua_State* L) {
  luaL_newmetatable(L, diagram_kind);
  lua_pushcfunction(L, destroy_object<DiagramObject>);
  lua_setfield(L, -2, "__gc");
  lua_pushcfunction(L, guarded<text>);
  lua_setfield(L, -2, "__tostring");
  lua_pushliteral(L, "diagram");
  lua_setfield(L, -2, "__metatable");
  push_functions(L, diagram_methods());
  lua_pushcclosure(L, guarded<index>, 1);
  lua_setfield(L, -2, "__index");
  lua_pop(L, 1);
}

}  // namespace plantloop::lua
