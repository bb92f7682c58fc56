// Families of velocity-form models from a diagram.

#include <fmt/format.h>

#include <algorithm>

#include "engine/analysis/linearise.h"
#include "identify/velocity/velocity_family.h"
#include "scripts/host/api.h"
#include "scripts/host/identify_objects.h"
#include "scripts/host/objects.h"
#include "scripts/host/session.h"

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

// The point that the table on top of the stack tells; what its models have in common goes into the family.
VelocityPoint point_of(lua_State* L, const DiagramObject& self, LineariseRequest request, VelocityFamily& family) {
  const Options options(L, lua_gettop(L), "a point", {"at", "diagram", "time", "trim"});
  VelocityPoint point;
  const auto at = options.number("at");
  if (!at) throw ScriptError("each point has 'at', the value of the scheduling variable, as in {at = 0}");
  point.at = *at;
  const DiagramObject* of = &self;
  if (options.push("diagram")) {
    of = test_object<DiagramObject>(L, -1, diagram_kind);
    if (of == nullptr)
      throw ScriptError("'diagram' of a point is a diagram, as in {at = 0, diagram = plant:with{level = 1}}");
    lua_pop(L, 1);  // the table keeps it
  }
  request.set = of->set;
  request.at = options.number("time");
  request.trim = options.flag("trim");
  const std::size_t outputs = request.outputs.size();
  request.outputs.insert(request.outputs.end(), request.inputs.begin(), request.inputs.end());
  Session& session = session_of(L);
  session.sandbox.work(L, 10000);
  Report report;
  const auto model = linearise(of->diagram->model_pointer(), request, report);
  if (!model) throw InputError(to_text(report, session.options.colour));
  session.tell(report);
  if (model->period > 0) throw ScriptError("the velocity form is of continuous diagrams, this one has sampled blocks");
  if (model->inputs.size() != request.inputs.size() || model->outputs.size() != request.outputs.size())
    throw ScriptError("inputs and outputs are single numbers; name the elements of a vector, as in x.2");
  if (model->states.empty()) throw ScriptError("the diagram has no states, so it has no velocity form");
  family.states = model->states;
  point.A = matrix_of(model->A, model->A.rows);
  point.B = matrix_of(model->B, model->B.rows);
  point.C = matrix_of(model->C, outputs);
  point.D = matrix_of(model->D, outputs);
  point.x = part_of(model->x, 0, model->x.size());
  point.y = part_of(model->y, 0, outputs);
  point.u = part_of(model->y, outputs, request.inputs.size());
  return point;
}

int velocity_family(lua_State* L) {
  const DiagramObject& self = self_argument<DiagramObject>(L, diagram_kind);
  const Options options(L, 2, "the options of velocity_family", {"path", "inputs", "outputs", "scheduling", "points"});
  const std::string path = options.text("path");
  if (path.empty()) throw ScriptError("'path' is the file to write, as in path = \"out/tank.yaml\"");
  LineariseRequest request;
  request.inputs = texts(L, options, "inputs");
  request.outputs = texts(L, options, "outputs");
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
    family.points.push_back(point_of(L, self, request, family));
    lua_pop(L, 1);
  }
  std::sort(family.points.begin(), family.points.end(),
            [](const VelocityPoint& a, const VelocityPoint& b) { return a.at < b.at; });
  for (std::size_t i = 1; i < family.points.size(); ++i) {
    if (family.points[i].at == family.points[i - 1].at)
      throw ScriptError(fmt::format("two points are at {:g}", family.points[i].at));
  }
  write_and_push(L, path, to_yaml(family), {".yaml"});
  return 1;
}

}  // namespace

Entries velocity_methods() {
  return {
      {"velocity_family", guarded<velocity_family>,
       "options: {path: string, inputs: string[], outputs: string[], scheduling?: string, points: table[]}", "string",
       "velocity-form models at points {at = value, diagram?, time?, trim?} as a file for velocity_blend; gives its "
       "path"},
  };
}

}  // namespace plantloop::lua
