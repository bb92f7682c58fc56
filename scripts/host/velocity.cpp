// Families of velocity-form models from a diagram.

#include <fmt/format.h>

#include <algorithm>

#include "identify/velocity/controller_family.h"
#include "identify/velocity/velocity_family.h"
#include "scripts/host/api.h"
#include "scripts/host/controller_design.h"
#include "scripts/host/identify_objects.h"
#include "scripts/host/local_model.h"

namespace plantloop::lua {
namespace {

using identify::VelocityFamily;
using identify::VelocityPoint;

Eigen::MatrixXd matrix_of(const DenseMatrix& m, std::size_t rows) {
  Eigen::MatrixXd result(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(m.columns));
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t j = 0; j < m.columns; ++j)
      result(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = m(i, j);
  }
  return result;
}

Eigen::VectorXd part_of(const std::vector<double>& values, std::size_t first, std::size_t count) {
  return Eigen::VectorXd::Map(values.data() + first, static_cast<Eigen::Index>(count));
}

// How the local models of one family are made.
struct LocalRequest {
  LineariseRequest linearise;
  double sampling_time = 0, dead_time = 0;  // s; 0: as the diagram is, none
};

// The point that the table on top of the stack tells; what its models have in common goes into the family.
VelocityPoint point_of(lua_State* L, const DiagramObject& self, const LocalRequest& local, VelocityFamily& family) {
  const Options options(L, lua_gettop(L), "a point", {"at", "diagram", "time", "trim"});
  VelocityPoint point;
  const auto at = options.number("at");
  if (!at) throw ScriptError("each point has 'at', the value of the scheduling variable, as in {at = 0}");
  point.at = *at;
  LinearModel model = local_model(L, self, local.linearise, options);
  const std::size_t outputs = local.linearise.outputs.size();
  const std::vector<double> u(model.y.begin() + static_cast<std::ptrdiff_t>(outputs), model.y.end());
  if (local.sampling_time > 0) {
    if (model.period > 0)
      throw ScriptError(
          fmt::format("the diagram is sampled every {:g} s already; leave out 'sampling_time'", model.period));
    model = sampled(model, local.sampling_time, local.dead_time, u);
  }
  if (!family.points.empty() && family.Ts != model.period)
    throw ScriptError(fmt::format("the points of a family have one sampling time; there are {:g} s and {:g} s",
                                  family.Ts, model.period));
  family.Ts = model.period;
  family.states = model.states;
  point.A = matrix_of(model.A, model.A.rows);
  point.B = matrix_of(model.B, model.B.rows);
  point.C = matrix_of(model.C, outputs);
  point.D = matrix_of(model.D, outputs);
  point.x = part_of(model.x, 0, model.x.size());
  point.y = part_of(model.y, 0, outputs);
  point.u = part_of(u, 0, u.size());
  return point;
}

template <typename Point>
void sort_points(std::vector<Point>& points) {
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.at < b.at; });
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].at == points[i - 1].at) throw ScriptError(fmt::format("two points are at {:g}", points[i].at));
  }
}

int velocity_family(lua_State* L) {
  const DiagramObject& self = self_argument<DiagramObject>(L, diagram_kind);
  const Options options(L, 2, "the options of velocity_family",
                        {"path", "inputs", "outputs", "scheduling", "points", "sampling_time", "dead_time"});
  const std::string path = options.text("path");
  if (path.empty()) throw ScriptError("'path' is the file to write, as in path = \"out/tank.yaml\"");
  LocalRequest local;
  LineariseRequest& request = local.linearise;
  request.inputs = texts(L, options, "inputs");
  request.outputs = texts(L, options, "outputs");
  if (options.has("sampling_time")) {
    local.sampling_time = options.number("sampling_time").value_or(0);
    if (!(local.sampling_time > 0)) options.wrong("sampling_time", "a number greater than 0, in s");
  }
  local.dead_time = options.number("dead_time").value_or(0);
  if (local.dead_time < 0) options.wrong("dead_time", "a number of at least 0, in s");
  if (local.dead_time > 0 && local.sampling_time == 0)
    throw ScriptError("'dead_time' goes with 'sampling_time'; in front of a continuous model stands a transport_delay");
  if (request.inputs.empty() || request.outputs.empty())
    throw ScriptError("'inputs' and 'outputs' are lists of signals, as in inputs = {\"u\"}, outputs = {\"y\"}");
  VelocityFamily family;
  family.scheduling = options.text("scheduling", request.outputs.front());
  for (const std::string& name : request.inputs) family.inputs.push_back({name, ""});
  for (const std::string& name : request.outputs) family.outputs.push_back({name, ""});
  constexpr const char* example = "'points' is a list, as in {{at = 0}, {at = 1, diagram = plant:with{level = 1}}}";
  if (!options.push("points") || !lua_istable(L, -1)) throw ScriptError(example);
  const lua_Integer count = luaL_len(L, -1);
  if (count == 0) throw ScriptError(example);
  for (lua_Integer i = 1; i <= count; ++i) {
    if (lua_rawgeti(L, -1, i) != LUA_TTABLE) throw ScriptError(example);
    family.points.push_back(point_of(L, self, local, family));
    lua_pop(L, 1);
  }
  sort_points(family.points);
  write_and_push(L, path, to_yaml(family), {".yaml"});
  return 1;
}

// The controller of the point that the table on top of the stack tells.
identify::ControllerPoint controller_of(lua_State* L, const DiagramObject& self, const LineariseRequest& request,
                                        const Options& design, std::vector<std::string>& states) {
  const Options options(L, lua_gettop(L), "a point", {"at", "diagram", "time", "trim", "model"});
  const auto at = options.number("at");
  if (!at) throw ScriptError("each point has 'at', the value of the scheduling variable, as in {at = 0}");
  LinearModel model;
  if (options.push("model")) {
    model = linear_model_argument(L, lua_gettop(L));
    lua_pop(L, 1);
  } else {
    model = local_model(L, self, request, options);
    model.C = model.C.block(0, 0, 1, model.C.columns);  // without the input's own value
    model.D = model.D.block(0, 0, 1, model.D.columns);
    model.outputs.resize(1);
  }
  identify::ControllerPoint point = designed(L, design, model);
  point.at = *at;
  states.clear();
  for (Eigen::Index j = 0; j < point.K.size(); ++j) {
    const auto k = static_cast<std::size_t>(j);
    states.push_back(k < model.states.size() ? model.states[k] : fmt::format("x{}", j + 1));
  }
  return point;
}

int controller_family(lua_State* L) {
  const DiagramObject& self = self_argument<DiagramObject>(L, diagram_kind);
  const Options options(L, 2, "the options of controller_family",
                        {"path", "input", "output", "scheduling", "points", "design"});
  const std::string path = options.text("path"), input = options.text("input"), output = options.text("output");
  if (path.empty()) throw ScriptError("'path' is the file to write, as in path = \"out/controllers.yaml\"");
  if (input.empty() || output.empty())
    throw ScriptError("'input' and 'output' are signals, as in input = \"u\", output = \"y\"");
  if (!options.push("design"))
    throw ScriptError("'design' tells how, as in {method = \"lambda_tuning\", controller = \"pi\", lambda = 2}");
  const Options design(L, lua_gettop(L), "the design", design_options());
  LineariseRequest request;
  request.inputs = {input};
  request.outputs = {output};
  identify::ControllerFamily family;
  family.scheduling = options.text("scheduling", output);
  constexpr const char* example = "'points' is a list, as in {{at = 0}, {at = 1, diagram = plant:with{level = 1}}}";
  if (!options.push("points") || !lua_istable(L, -1) || luaL_len(L, -1) == 0) throw ScriptError(example);
  for (lua_Integer i = 1, count = luaL_len(L, -1); i <= count; ++i) {
    if (lua_rawgeti(L, -1, i) != LUA_TTABLE) throw ScriptError(example);
    family.points.push_back(controller_of(L, self, request, design, family.states));
    lua_pop(L, 1);
  }
  sort_points(family.points);
  write_and_push(L, path, to_yaml(family), {".yaml"});
  return 1;
}

}  // namespace

Entries velocity_methods() {
  return {
      {"controller_family", guarded<controller_family>,
       "options: {path: string, input: string, output: string, scheduling?: string, points: table[], design: table}",
       "string",
       "a controller for each point {at = value, diagram?, time?, trim?, model?}, designed as pl.tune does, as a file "
       "for "
       "blended_controller; gives its path"},
      {"velocity_family", guarded<velocity_family>,
       "options: {path: string, inputs: string[], outputs: string[], scheduling?: string, points: table[], "
       "sampling_time?: "
       "number, dead_time?: number}",
       "string",
       "velocity-form models at points {at = value, diagram?, time?, trim?} as a file for velocity_blend; gives its "
       "path. Of a sampled diagram the models are sampled, of a continuous one with `sampling_time`"},
  };
}

}  // namespace plantloop::lua
