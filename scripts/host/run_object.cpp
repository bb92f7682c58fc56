// Runs: columns by name, methods by ':'.
//
// run.save and the start of run:save(...) are the same to Lua. A column wins: its vector carries the method of the same
// name along and hands calls on to it, so both work whatever a diagram calls its signals.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "app/figures.h"
#include "engine/base/files.h"
#include "engine/run/measures.h"
#include "scripts/host/api.h"
#include "scripts/host/objects.h"
#include "scripts/host/picture.h"
#include "scripts/host/session.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

RunObject& self_of(lua_State* L) { return *self_argument<RunPointer>(L, run_kind); }

std::vector<std::string> column_names(const RunObject& run) {
  std::vector<std::string> names{"time"};
  for (const RecordedColumn& column : run.recording().columns) {
    if (!column.hidden) names.push_back(column.name);
  }
  return names;
}

// The columns name.1, name.2, ... of a vector signal; none when there is no name.1.
std::vector<std::size_t> elements_of(const Recording& recording, const std::string& name) {
  std::vector<std::size_t> columns;
  for (int at = recording.find(name + ".1"); at >= 0;
       at = recording.find(fmt::format("{}.{}", name, columns.size() + 1))) {
    columns.push_back(static_cast<std::size_t>(at));
  }
  return columns;
}

bool push_column(lua_State* L, const RunObject& run, const std::string& name) {
  const Recording& recording = run.recording();
  if (name == "time") {
    push_vector(L, recording.time()).is_frozen = true;
    return true;
  }
  std::vector<std::size_t> columns;
  const int found = recording.find(name);
  if (found >= 0) {
    columns.push_back(static_cast<std::size_t>(found));
  } else {
    columns = elements_of(recording, name);
  }
  if (columns.empty()) return false;
  const std::size_t rows = recording.rows();
  Array& array = push_array(L, static_cast<std::int64_t>(rows), static_cast<std::int64_t>(columns.size()), found < 0);
  double* out = array.data();
  for (const std::size_t column : columns) {
    for (std::size_t row = 0; row < rows; ++row) *out++ = recording.at(row, column);
  }
  array.is_frozen = true;
  return true;
}

[[noreturn]] void no_column(const RunObject& run, const std::string& name) {
  throw ScriptError(fmt::format("the run has no column '{}'{}", name, suggestion(name, column_names(run))));
}

// Upvalue 1: the methods. The run's user value keeps the columns that were asked for.
int index(lua_State* L) {
  const RunObject& run = **static_cast<RunPointer*>(lua_touserdata(L, 1));
  if (lua_type(L, 2) != LUA_TSTRING) {
    throw ScriptError(fmt::format("the columns of a run have names; here is {}", describe(L, 2)));
  }
  const std::string name = lua_tostring(L, 2);
  lua_getiuservalue(L, 1, 1);
  lua_pushvalue(L, 2);
  if (lua_rawget(L, 3) != LUA_TNIL) return 1;
  lua_pop(L, 1);
  const int method = lua_getfield(L, lua_upvalueindex(1), name.c_str());  // at 4
  if (!push_column(L, run, name)) {
    if (method == LUA_TNIL) no_column(run, name);
    return 1;
  }
  lua_pushvalue(L, 4);
  lua_setiuservalue(L, -2, 1);
  lua_pushvalue(L, 2);
  lua_pushvalue(L, -2);
  lua_rawset(L, 3);
  return 1;
}

int no_assignment(lua_State* L) {
  (void)L;
  throw ScriptError("a run is what was recorded, it cannot be changed");
}

int text(lua_State* L) {
  const RunObject& run = **static_cast<RunPointer*>(lua_touserdata(L, 1));
  push_text(L, fmt::format("a run of {} to {:g} s: {} rows of {}", run.diagram->model().path, run.run.options.stop,
                           run.recording().rows(), fmt::join(column_names(run), ", ")));
  return 1;
}

int save_as(lua_State* L, const std::string& path, const std::string& format) {
  const RunObject& run = self_of(L);
  std::string bytes;
  if (format == ".csv") {
    bytes = to_csv(run.recording());
  } else if (format == ".json") {
    bytes = to_json(run.recording());
  } else if (format == ".npz") {
    bytes = to_npz(run.recording());
  } else {
    throw ScriptError(fmt::format("cannot save '{}': the name must end in .csv, .json or .npz", path));
  }
  const FileResult place = session_of(L).writable(path);
  const std::string error = place.ok() ? write_file(place.value, bytes) : place.error;
  if (!error.empty()) throw ScriptError(fmt::format("cannot save '{}': {}", path, error));
  push_text(L, place.value);
  return 1;
}

int save(lua_State* L) {
  const std::string path = text_argument(L, 2, "path");
  return save_as(L, path, std::filesystem::path(path).extension().string());
}

int csv(lua_State* L) { return save_as(L, text_argument(L, 2, "path"), ".csv"); }

MeasureOptions measure_options(lua_State* L, int index) {
  const Options options(L, index, "the options of measure", {"from", "until", "band", "step"});
  MeasureOptions result;
  if (const auto from = options.number("from")) result.from = *from;
  if (const auto until = options.number("until")) result.until = *until;
  if (const auto band = options.number("band")) result.band = *band;
  if (options.push("step")) {
    const Options step(L, -1, "the step of a measure", {"at", "until", "from", "to"});
    result.step = {step.number("at"), step.number("until"), step.number("from"), step.number("to")};
    lua_pop(L, 1);
  }
  return result;
}

int measure_column(lua_State* L) {
  const RunObject& run = self_of(L);
  const std::string name = text_argument(L, 2, "measure");
  std::vector<std::string> names;
  for (const MeasureInfo& info : measures()) names.emplace_back(info.name);
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    throw ScriptError(fmt::format("there is no measure '{}'{}", name, suggestion(name, names)));
  }
  const std::size_t column = column_of(run, text_argument(L, 3, "column"));
  lua_pushnumber(L, plantloop::measure(run.recording(), column, name, measure_options(L, 4)));
  return 1;
}

int value_at(lua_State* L) {
  const RunObject& run = self_of(L);
  const std::size_t column = column_of(run, text_argument(L, 2, "column"));
  const Operand times = operand_argument(L, 3, "time");
  const std::string side = is_given(L, 4) ? text_argument(L, 4, "side") : "right";
  if (side != "left" && side != "right") throw ScriptError("'side' must be left or right");
  const double first = run.recording().time().front();
  const double last = run.recording().time().back();
  const auto value = [&](double t) {
    if (!(t >= first && t <= last)) {
      throw ScriptError(
          fmt::format("{:g} s lies outside of the run, which lasts from {:g} s to {:g} s", t, first, last));
    }
    return run.recording().value(column, t, side == "left");
  };
  Array* result = push_common(L, {times});
  if (result == nullptr) {
    lua_pushnumber(L, value(times.number));
    return 1;
  }
  count_elements(L, 8 * static_cast<double>(result->size()));
  for (std::int64_t i = 0; i < result->size(); ++i) result->data()[i] = value(times[i]);
  return 1;
}

int verdicts(lua_State* L) {
  const RunObject& run = self_of(L);
  lua_newtable(L);
  for (std::size_t i = 0; i < run.run.verdicts.size(); ++i) {
    const Verdict& verdict = run.run.verdicts[i];
    lua_newtable(L);
    push_text(L, verdict.text);
    lua_setfield(L, -2, "text");
    push_text(L, verdict.measured);
    lua_setfield(L, -2, "measured");
    lua_pushboolean(L, verdict.met ? 1 : 0);
    lua_setfield(L, -2, "met");
    lua_rawseti(L, -2, static_cast<lua_Integer>(i) + 1);
  }
  return 1;
}

int statistics(lua_State* L) {
  const RunStatistics& s = self_of(L).run.statistics;
  const std::pair<const char*, std::int64_t> numbers[] = {{"steps", s.solver.steps},
                                                          {"rejected", s.solver.rejected},
                                                          {"evaluations", s.solver.evaluations},
                                                          {"jacobians", s.solver.jacobians},
                                                          {"rows", s.rows},
                                                          {"hits", s.hits},
                                                          {"events", s.events},
                                                          {"mode_changes", s.mode_changes}};
  lua_newtable(L);
  for (const auto& [name, number] : numbers) {
    lua_pushinteger(L, number);
    lua_setfield(L, -2, name);
  }
  return 1;
}

int columns(lua_State* L) {
  const std::vector<std::string> names = column_names(self_of(L));
  lua_newtable(L);
  for (std::size_t i = 0; i < names.size(); ++i) {
    push_text(L, names[i]);
    lua_rawseti(L, -2, static_cast<lua_Integer>(i) + 1);
  }
  return 1;
}

int unit(lua_State* L) {
  const RunObject& run = self_of(L);
  const std::string name = text_argument(L, 2, "column");
  push_text(L, name == "time" ? "s" : run.recording().columns[column_of(run, name)].unit);
  return 1;
}

int events(lua_State* L) {
  const RunObject& run = self_of(L);
  lua_newtable(L);
  for (const auto& [name, times] : run.recording().events) {
    push_text(L, name);
    push_vector(L, times);
    lua_rawset(L, -3);
  }
  return 1;
}

const FigureDecl& declared_figure(const RunObject& run, const std::string& name) {
  std::vector<std::string> names;
  for (const FigureDecl& declared : run.diagram->model().figures) {
    if (declared.name == name) return declared;
    names.push_back(declared.name);
  }
  throw ScriptError(fmt::format("the diagram has no figure '{}'{}", name, suggestion(name, names)));
}

int figure(lua_State* L) {
  const RunObject& run = self_of(L);
  const std::string name = text_argument(L, 2, "name");
  const FigureDecl& declared = declared_figure(run, name);
  auto made = std::make_shared<Figure>(make_figure(declared, run.run, run.diagram->model()));
  push_object(L, figure_kind, FigureObject{std::move(made), {}});
  return 1;
}

int figures(lua_State* L) {
  const RunObject& run = self_of(L);
  const std::string folder = is_given(L, 2) ? text_argument(L, 2, "folder") : "out";
  const std::string format = is_given(L, 3) ? text_argument(L, 3, "format") : "png";
  const Model& model = run.diagram->model();
  if (model.figures.empty()) throw ScriptError(fmt::format("{} has no figures: section to draw", model.path));
  lua_newtable(L);
  lua_Integer count = 0;
  for (const FigureDecl& declared : model.figures) {
    const std::string path = fmt::format("{}/{}.{}", folder, declared.name, format);
    push_text(L, save_picture(session_of(L), make_figure(declared, run.run, model), path));
    lua_rawseti(L, -2, ++count);
  }
  return 1;
}

int destroy(lua_State* L) {
  auto& run = *static_cast<RunPointer*>(lua_touserdata(L, 1));
  if (run) session_of(L).sandbox.release(run->bytes);
  run.~RunPointer();
  return 0;
}

}  // namespace

std::size_t column_of(const RunObject& run, const std::string& name) {
  const int found = run.recording().find(name);
  if (found < 0) no_column(run, name);
  return static_cast<std::size_t>(found);
}

void push_run(lua_State* L, DiagramRun run, std::shared_ptr<Diagram> diagram) {
  auto object = std::make_unique<RunObject>(std::move(run), std::move(diagram));
  const Recording& recording = object->recording();
  std::size_t bytes = recording.rows() * (recording.columns.size() * sizeof(double) + sizeof(double) + 1);
  for (const auto& rows : recording.hits) bytes += rows.size() * sizeof(std::size_t);
  session_of(L).sandbox.hold(L, bytes);
  object->bytes = bytes;
  push_object(L, run_kind, std::move(object));
  lua_newtable(L);
  lua_setiuservalue(L, -2, 1);
}

Entries run_methods() {
  return {
      {"save", guarded<save>, "path: string", "string", "writes the columns as .csv, .json or .npz; gives the path"},
      {"csv", guarded<csv>, "path: string", "string", "writes the columns as CSV; gives the path"},
      {"measure", guarded<measure_column>,
       "measure: string, column: string, options?: {from?: number, until?: number, band?: number, step?: {at?: number, "
       "until?: number, from?: number, to?: number}}",
       "number", "max, min, max_abs, rms, final, overshoot, undershoot, settling_time or rise_time, as in `expect:`"},
      {"at", guarded<value_at>, "column: string, time: number|pl.Vector, side?: \"left\"|\"right\"", "number|pl.Vector",
       "a column's value between rows, too; at a jump the right side unless told"},
      {"verdicts", guarded<verdicts>, "", "{text: string, met: boolean, measured: string}[]",
       "the answers to the diagram's `expect:` section"},
      {"statistics", guarded<statistics>, "", "table<string, integer>",
       "steps, rejected, evaluations, jacobians, rows, hits, events, mode_changes"},
      {"columns", guarded<columns>, "", "string[]", "the names of the columns, time first"},
      {"unit", guarded<unit>, "column: string", "string", "the unit of a column; empty when unknown"},
      {"events", guarded<events>, "", "table<string, pl.Vector>", "the times of each kind of event"},
      {"figure", guarded<figure>, "name: string", "pl.Figure", "one of the diagram's own figures, to be added to"},
      {"figures", guarded<figures>, "folder?: string, format?: \"png\"|\"svg\"|\"pdf\"", "string[]",
       "draws the diagram's own figures into a folder; gives the paths"},
  };
}

void open_runs(lua_State* L) {
  luaL_newmetatable(L, run_kind);
  const std::pair<const char*, lua_CFunction> functions[] = {
      {"__gc", destroy}, {"__tostring", guarded<text>}, {"__newindex", guarded<no_assignment>}};
  for (const auto& [name, function] : functions) {
    lua_pushcfunction(L, function);
    lua_setfield(L, -2, name);
  }
  lua_pushliteral(L, "run");
  lua_setfield(L, -2, "__metatable");
  push_functions(L, run_methods());
  lua_pushcclosure(L, guarded<index>, 1);
  lua_setfield(L, -2, "__index");
  lua_pop(L, 1);
}

}  // namespace plantloop::lua
