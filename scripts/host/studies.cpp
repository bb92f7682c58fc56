// Many runs of one diagram: sweeps over parameters, and fits of parameters to data.

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "engine/analysis/fit.h"
#include "engine/analysis/sweep.h"
#include "engine/base/numbers.h"
#include "scripts/host/api.h"
#include "scripts/host/objects.h"
#include "scripts/host/session.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

[[noreturn]] void fail(const Session& session, const Report& report) {
  throw InputError(to_text(report, session.options.colour));
}

// The names of the table on top of the stack, sorted: Lua's tables have no order.
std::vector<std::string> names_of(lua_State* L, const char* what, const char* example) {
  if (!lua_istable(L, -1)) throw ScriptError(fmt::format("'{}' is a table, as in {}", what, example));
  std::vector<std::string> names;
  lua_pushnil(L);
  while (lua_next(L, -2) != 0) {
    if (lua_type(L, -2) != LUA_TSTRING)
      throw ScriptError(fmt::format("'{}' has entries by path, as in {}; here is {}", what, example, describe(L, -2)));
    names.emplace_back(lua_tostring(L, -2));
    lua_pop(L, 1);
  }
  std::sort(names.begin(), names.end());
  return names;
}

// The value on top of the stack as a diagram would write it; popped.
std::string take_expression(lua_State* L, const std::string& path) {
  const bool is_number = lua_type(L, -1) == LUA_TNUMBER;
  if (!is_number && lua_type(L, -1) != LUA_TSTRING)
    throw ScriptError(fmt::format("'{}' is set to numbers or expressions, here is {}", path, describe(L, -1)));
  std::string text = is_number ? shortest(lua_tonumber(L, -1)) : lua_tostring(L, -1);
  lua_pop(L, 1);
  return text;
}

// A list of numbers and expressions, or a vector, on top of the stack; popped.
std::vector<std::string> take_values(lua_State* L, const std::string& path) {
  std::vector<std::string> texts;
  if (lua_istable(L, -1)) {
    const lua_Integer count = luaL_len(L, -1);
    for (lua_Integer i = 1; i <= count; ++i) {
      lua_rawgeti(L, -1, i);
      texts.push_back(take_expression(L, path));
    }
  } else {
    for (const double v : numbers_argument(L, -1, path)) texts.push_back(shortest(v));
  }
  lua_pop(L, 1);
  return texts;
}

std::vector<SweepPlan::Values> values_of(lua_State* L, const Options& options, const char* key, const char* example) {
  std::vector<SweepPlan::Values> all;
  if (!options.push(key)) return all;
  for (const std::string& path : names_of(L, key, example)) {
    lua_getfield(L, -1, path.c_str());
    all.push_back({path, take_values(L, path)});
  }
  lua_pop(L, 1);
  return all;
}

// {k = {"normal", 1, 0.1}}
std::vector<SweepPlan::Random> random_of(lua_State* L, const Options& options) {
  std::vector<SweepPlan::Random> all;
  constexpr const char* example = "{k = {\"normal\", 1, 0.1}}";
  if (!options.push("random")) return all;
  for (const std::string& path : names_of(L, "random", example)) {
    SweepPlan::Random& random = all.emplace_back();
    random.path = path;
    const auto wrong = [&] {
      throw ScriptError(fmt::format("'random' has a distribution and two numbers for each path, as in {}", example));
    };
    if (lua_getfield(L, -1, path.c_str()) != LUA_TTABLE) wrong();
    if (lua_rawgeti(L, -1, 1) != LUA_TSTRING) wrong();
    random.distribution = lua_tostring(L, -1);
    if (lua_rawgeti(L, -2, 2) != LUA_TNUMBER) wrong();
    random.a = lua_tonumber(L, -1);
    if (lua_rawgeti(L, -3, 3) != LUA_TNUMBER) wrong();
    random.b = lua_tonumber(L, -1);
    lua_pop(L, 4);
  }
  lua_pop(L, 1);
  return all;
}

DiagramObject& diagram_option(lua_State* L, const Options& options, const char* function) {
  DiagramObject* diagram = nullptr;
  if (options.push("diagram")) {
    diagram = test_object<DiagramObject>(L, -1, diagram_kind);
    lua_pop(L, 1);  // the table of options keeps it
  }
  if (diagram == nullptr)
    throw ScriptError(
        fmt::format("'diagram' must be a diagram, as in pl.{}{{diagram = pl.load \"loop.yaml\", ...}}", function));
  return *diagram;
}

// The table of overrides on top of the stack, put over those that are known.
void take_overrides(lua_State* L, Overrides& set) {
  for (const std::string& path : names_of(L, "set", "{k = 2}")) {
    lua_getfield(L, -1, path.c_str());
    const std::string text = take_expression(L, path);
    std::erase_if(set, [&](const Override& o) { return o.path == path; });
    set.push_back({path, text});
  }
}

RunRequest run_options(lua_State* L, const Options& options, const DiagramObject& diagram) {
  RunRequest run{.set = diagram.set};
  if (options.push("set")) {
    take_overrides(L, run.set);
    lua_pop(L, 1);
  }
  run.start = options.number("start");
  run.step = options.number("step");
  run.rtol = options.number("rtol");
  run.atol = options.number("atol");
  run.max_step = options.number("max_step");
  if (options.has("solver")) run.solver = options.text("solver");
  return run;
}

std::size_t count_option(const Options& options, const char* key, std::size_t fallback) {
  const auto number = options.number(key);
  if (!number) return fallback;
  if (!(*number >= 0 && *number <= 1e9) || *number != std::floor(*number)) options.wrong(key, "a whole number");
  return static_cast<std::size_t>(*number);
}

int sweep_diagram(lua_State* L) {
  const Options options(L, 1, "the options of sweep",
                        {"diagram", "grid", "list", "random", "draws", "seed", "threads", "set", "start", "stop",
                         "step", "solver", "rtol", "atol", "max_step", "output_interval"});
  const DiagramObject self = diagram_option(L, options, "sweep");
  SweepPlan plan;
  plan.grid = values_of(L, options, "grid", "{k = {1, 2, 5}}");
  plan.list = values_of(L, options, "list", "{k = {1, 2, 5}}");
  plan.random = random_of(L, options);
  plan.draws = count_option(options, "draws", 1);
  plan.seed = count_option(options, "seed", 1);
  Session& session = session_of(L);
  Report report;
  const auto points = sweep_points(plan, report);
  if (!points) fail(session, report);
  SweepRequest request;
  request.run = run_options(L, options, self);
  request.run.stop = options.number("stop");
  request.run.output_interval = options.number("output_interval");
  request.points = *points;
  request.threads = count_option(options, "threads", 0);
  session.sandbox.work(L, 1000 * static_cast<double>(points->size()));
  session.sandbox.tidy(L);
  request.run.max_memory = static_cast<double>(session.sandbox.bytes_left()) / static_cast<double>(points->size());
  SweepControl control;
  control.cancel = session.options.cancel;
  if (session.options.time_limit > 0) control.time_limit = std::max(1e-3, session.sandbox.seconds_left());
  auto swept = sweep(*self.diagram, request, report, control);
  session.sandbox.work(L, 1000);
  if (!swept) fail(session, report);
  lua_createtable(L, static_cast<int>(swept->size()), 0);
  for (std::size_t i = 0; i < swept->size(); ++i) {
    SweepPoint& point = (*swept)[i];
    lua_createtable(L, 0, 3);
    lua_createtable(L, 0, static_cast<int>(point.set.size()));
    for (const Override& o : point.set) {
      if (const auto number = parse_number(o.text))
        lua_pushnumber(L, *number);
      else
        push_text(L, o.text);
      lua_setfield(L, -2, o.path.c_str());
    }
    lua_setfield(L, -2, "set");
    if (point.run) {
      push_run(L, std::move(*point.run), self.diagram);
      lua_setfield(L, -2, "run");
    } else {
      push_text(L, point.failure);
      lua_setfield(L, -2, "failure");
    }
    lua_rawseti(L, -2, static_cast<lua_Integer>(i) + 1);
  }
  return 1;
}

// --- fit ----------------------------------------------------------------------------------------------------------

// {"k", tau = 0.5}: names, and names with start values.
std::vector<FitParameter> parameters_of(lua_State* L, const Options& options) {
  constexpr const char* example = "{\"k\", tau = 0.5}";
  std::vector<FitParameter> parameters, with_start;
  if (!options.push("parameters") || !lua_istable(L, -1))
    throw ScriptError(
        fmt::format("'parameters' is a table of paths, with start values where wanted, as in {}", example));
  const lua_Integer count = luaL_len(L, -1);
  for (lua_Integer i = 1; i <= count; ++i) {
    if (lua_rawgeti(L, -1, i) != LUA_TSTRING)
      throw ScriptError(fmt::format("'parameters' has paths, as in {}; here is {}", example, describe(L, -1)));
    parameters.push_back({lua_tostring(L, -1), {}});
    lua_pop(L, 1);
  }
  lua_pushnil(L);
  while (lua_next(L, -2) != 0) {
    if (lua_type(L, -2) == LUA_TSTRING) {
      if (lua_type(L, -1) != LUA_TNUMBER)
        throw ScriptError(fmt::format("'{}' starts at a number, as in {}", lua_tostring(L, -2), example));
      with_start.push_back({lua_tostring(L, -2), lua_tonumber(L, -1)});
    }
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
  std::sort(with_start.begin(), with_start.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
  parameters.insert(parameters.end(), with_start.begin(), with_start.end());
  return parameters;
}

void read_bounds(lua_State* L, const Options& options, std::vector<FitParameter>& parameters) {
  constexpr const char* example = "{k = {0, 10}}";
  if (!options.push("bounds")) return;
  for (const std::string& path : names_of(L, "bounds", example)) {
    const auto it =
        std::find_if(parameters.begin(), parameters.end(), [&](const FitParameter& p) { return p.path == path; });
    if (it == parameters.end())
      throw ScriptError(fmt::format("'bounds' has '{}', which is not among the fitted parameters", path));
    lua_getfield(L, -1, path.c_str());
    const std::vector<double> pair = numbers_argument(L, -1, "bounds of " + path);
    if (pair.size() != 2)
      throw ScriptError(fmt::format("'bounds' has a lower and an upper one for each path, as in {}", example));
    it->lower = pair[0];
    it->upper = pair[1];
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
}

// Vectors by signal with the times, and of several experiments `set`, in the table on top of the stack.
FitExperiment experiment_of(lua_State* L, bool several) {
  const char* const example = several ? "{time = t, y = y, set = {k = 2}}" : "{time = t, y = y}";
  FitExperiment experiment;
  bool has_time = false;
  for (const std::string& name : names_of(L, "data", example)) {
    lua_getfield(L, -1, name.c_str());
    if (several && name == "set") {
      take_overrides(L, experiment.set);
    } else if (std::vector<double> values = numbers_argument(L, -1, "data of " + name); name == "time") {
      has_time = true;
      experiment.data.time = std::move(values);
    } else {
      experiment.data.columns.push_back({name, std::move(values)});
    }
    lua_pop(L, 1);
  }
  if (!has_time) throw ScriptError(fmt::format("'data' has no 'time'; it is as in {}", example));
  return experiment;
}

// One experiment, or a list of them.
std::vector<FitExperiment> experiments_of(lua_State* L, const Options& options) {
  if (!options.push("data"))
    throw ScriptError("'data' is a table of vectors by signal, with the times, as in {time = t, y = y}");
  std::vector<FitExperiment> experiments;
  const lua_Integer count = lua_istable(L, -1) ? luaL_len(L, -1) : 0;
  for (lua_Integer i = 1; i <= count; ++i) {
    lua_rawgeti(L, -1, i);
    experiments.push_back(experiment_of(L, true));
    lua_pop(L, 1);
  }
  if (count == 0) experiments.push_back(experiment_of(L, false));
  lua_pop(L, 1);
  if (!options.push("weights")) return experiments;
  for (const std::string& name : names_of(L, "weights", "{y = 10}")) {
    if (lua_getfield(L, -1, name.c_str()) != LUA_TNUMBER)
      throw ScriptError(fmt::format("the weight of '{}' is a number, here is {}", name, describe(L, -1)));
    bool known = false;
    for (FitExperiment& experiment : experiments) {
      for (FitData::Column& column : experiment.data.columns) {
        if (column.signal != name) continue;
        column.weight = lua_tonumber(L, -1);
        known = true;
      }
    }
    if (!known) throw ScriptError(fmt::format("'weights' has '{}', which is not in the data", name));
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
  return experiments;
}

void set_matrix(lua_State* L, const char* key, const DenseMatrix& m) {
  Array& array = push_array(L, static_cast<std::int64_t>(m.rows), static_cast<std::int64_t>(m.columns), true);
  for (std::size_t i = 0; i < m.rows; ++i) {
    for (std::size_t j = 0; j < m.columns; ++j) array.data()[i + j * m.rows] = m(i, j);
  }
  lua_setfield(L, -2, key);
}

void push_result(lua_State* L, const FitResult& r, double confidence) {
  lua_newtable(L);
  const auto by_path = [&](const char* key, auto push) {
    lua_newtable(L);
    for (const FitResult::Estimate& e : r.parameters) {
      push(e);
      lua_setfield(L, -2, e.path.c_str());
    }
    lua_setfield(L, -2, key);
  };
  const auto number = [&](const char* key, double value) {
    lua_pushnumber(L, value);
    lua_setfield(L, -2, key);
  };
  const auto text = [&](const char* key, const std::string& value) {
    push_text(L, value);
    lua_setfield(L, -2, key);
  };
  by_path("values", [&](const auto& e) { lua_pushnumber(L, e.value); });
  by_path("deviations", [&](const auto& e) { lua_pushnumber(L, e.deviation); });
  by_path("intervals", [&](const auto& e) { push_vector(L, std::vector<double>{e.lower, e.upper}); });
  lua_newtable(L);
  for (std::size_t k = 0; k < r.parameters.size(); ++k) {
    push_text(L, r.parameters[k].path);
    lua_rawseti(L, -2, static_cast<lua_Integer>(k) + 1);
  }
  lua_setfield(L, -2, "parameters");
  set_matrix(L, "covariance", r.covariance);
  set_matrix(L, "correlation", r.correlation);
  // By signal; of several experiments a list of such tables.
  const auto by_signal = [&](const char* key, auto push) {
    lua_newtable(L);
    for (std::size_t e = 0; e < r.experiments; ++e) {
      if (r.experiments > 1) lua_newtable(L);
      for (const FitResult::Column& c : r.columns) {
        if (c.experiment != e) continue;
        push(c);
        lua_setfield(L, -2, c.signal.c_str());
      }
      if (r.experiments > 1) lua_rawseti(L, -2, static_cast<lua_Integer>(e) + 1);
    }
    lua_setfield(L, -2, key);
  };
  by_signal("rms", [&](const auto& c) { lua_pushnumber(L, c.rms); });
  by_signal("fitted", [&](const auto& c) { push_vector(L, c.fitted); });
  push_vector(L, r.costs);
  lua_setfield(L, -2, "costs");
  number("cost", r.cost);
  number("iterations", r.iterations);
  text("why", r.why);
  text("derivatives", r.gradient);
  text("report", to_text(r, confidence));
  lua_pushboolean(L, r.converged ? 1 : 0);
  lua_setfield(L, -2, "converged");
}

int fit_diagram(lua_State* L) {
  const Options options(
      L, 1, "the options of fit",
      {"diagram", "parameters", "bounds", "data", "weights", "absolute", "confidence", "starts", "seed", "threads",
       "differences", "set", "start", "step", "solver", "rtol", "atol", "max_step"});
  const DiagramObject self = diagram_option(L, options, "fit");
  FitRequest request;
  request.run = run_options(L, options, self);
  request.parameters = parameters_of(L, options);
  read_bounds(L, options, request.parameters);
  request.experiments = experiments_of(L, options);
  request.absolute = options.flag("absolute");
  request.differences = options.flag("differences");
  request.confidence = options.number("confidence").value_or(request.confidence);
  if (!(request.confidence > 0 && request.confidence < 1)) options.wrong("confidence", "a number between 0 and 1");
  request.starts = std::max<std::size_t>(1, count_option(options, "starts", 1));
  request.seed = count_option(options, "seed", 1);
  request.threads = count_option(options, "threads", 0);
  Session& session = session_of(L);
  session.sandbox.work(L, 10000 * static_cast<double>(request.starts));
  std::atomic<bool> stop{false};
  FitControl control;
  control.cancel = &stop;
  control.progress = [&](int, double) {
    const bool cancelled = session.options.cancel != nullptr && session.options.cancel->load();
    if (cancelled || (session.options.time_limit > 0 && session.sandbox.seconds_left() <= 0)) stop = true;
  };
  Report report;
  const auto result = fit(self.diagram->model_pointer(), request, report, control);
  session.sandbox.work(L, 10000);
  if (!result) fail(session, report);
  session.tell(report);
  push_result(L, *result, request.confidence);
  return 1;
}

}  // namespace

Entries study_functions() {
  return {
      {"sweep", guarded<sweep_diagram>,
       "options: {diagram: pl.Diagram, grid?: table<string, pl.Vector|table>, list?: table<string, pl.Vector|table>, "
       "random?: table<string, table>, draws?: integer, seed?: integer, threads?: integer, set?: table<string, "
       "number|string>, start?: number, stop?: number, step?: number, solver?: string, rtol?: number, atol?: number, "
       "max_step?: number, output_interval?: number}",
       "table",
       "runs for every combination of the grid, each row of the list and each draw, the last one fastest, on threads; "
       "a list of tables with `set`, and `run` or `failure`"},
      {"fit", guarded<fit_diagram>,
       "options: {diagram: pl.Diagram, parameters: table, bounds?: table<string, table>, data: table, weights?: "
       "table<string, number>, absolute?: boolean, confidence?: number, starts?: integer, seed?: "
       "integer, threads?: integer, differences?: boolean, set?: table<string, number|string>, start?: number, step?: "
       "number, solver?: string, rtol?: number, atol?: number, max_step?: number}",
       "table",
       "parameters fitted to data by least squares; data is {time = t, y = y}, or a list of such tables, one for each "
       "experiment, with a set of its own: values, deviations, intervals, covariance, correlation, fitted, "
       "rms, report, derivatives, converged, why"},
  };
}

}  // namespace plantloop::lua
