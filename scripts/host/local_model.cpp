// Linearisation at the points of a family.

#include "scripts/host/local_model.h"

#include <string>

namespace plantloop::lua {

LinearModel local_model(lua_State* L, const DiagramObject& self, LineariseRequest request, const Options& point) {
  const DiagramObject* of = &self;
  if (point.push("diagram")) {
    of = test_object<DiagramObject>(L, -1, diagram_kind);
    if (of == nullptr)
      throw ScriptError("'diagram' of a point is a diagram, as in {at = 0, diagram = plant:with{level = 1}}");
    lua_pop(L, 1);  // the table keeps it
  }
  request.set = of->set;
  request.at = point.number("time");
  request.trim = point.flag("trim");
  request.outputs.insert(request.outputs.end(), request.inputs.begin(), request.inputs.end());
  Session& session = session_of(L);
  session.sandbox.work(L, 10000);
  Report report;
  auto model = linearise(of->diagram->model_pointer(), request, report);
  if (!model) throw InputError(to_text(report, session.options.colour));
  session.tell(report);
  if (model->inputs.size() != request.inputs.size() || model->outputs.size() != request.outputs.size())
    throw ScriptError("inputs and outputs are single numbers; name the elements of a vector, as in x.2");
  if (model->states.empty()) throw ScriptError("the diagram has no states, so there is nothing to linearise");
  return std::move(*model);
}

}  // namespace plantloop::lua
