// What a diagram can be asked beside a run: its linear model, a rest, many runs.

#include <fmt/format.h>

#include <algorithm>
#include <complex>

#include "engine/analysis/linearise.h"
#include "engine/base/numbers.h"
#include "scripts/host/api.h"
#include "scripts/host/objects.h"
#include "scripts/host/session.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

// A text or a list of texts at the top of the stack, which is popped.
std::vector<std::string> texts_of(lua_State* L, const char* what) {
  std::vector<std::string> texts;
  if (lua_type(L, -1) == LUA_TSTRING) {
    texts.emplace_back(lua_tostring(L, -1));
  } else if (lua_istable(L, -1)) {
    const lua_Integer count = luaL_len(L, -1);
    for (lua_Integer i = 1; i <= count; ++i) {
      if (lua_rawgeti(L, -1, i) != LUA_TSTRING)
        throw ScriptError(fmt::format("'{}' is a list of paths, as in {{\"u\", \"plant.x\"}}", what));
      texts.emplace_back(lua_tostring(L, -1));
      lua_pop(L, 1);
    }
  } else {
    throw ScriptError(fmt::format("'{}' is a path or a list of paths, it is {}", what, describe(L, -1)));
  }
  lua_pop(L, 1);
  return texts;
}

// {y = 2}: a table of numbers by path, at the top of the stack, which is popped.
std::vector<std::pair<std::string, double>> numbers_of(lua_State* L, const char* what) {
  std::vector<std::pair<std::string, double>> numbers;
  if (!lua_istable(L, -1)) throw ScriptError(fmt::format("'{}' is a table, as in {{y = 2}}", what));
  lua_pushnil(L);
  while (lua_next(L, -2) != 0) {
    if (lua_type(L, -2) != LUA_TSTRING || lua_type(L, -1) != LUA_TNUMBER)
      throw ScriptError(fmt::format("'{}' has numbers by path, as in {{y = 2}}", what));
    numbers.emplace_back(lua_tostring(L, -2), lua_tonumber(L, -1));
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

void set_matrix(lua_State* L, const char* key, const DenseMatrix& m) {
  Array& array = push_array(L, static_cast<std::int64_t>(m.rows), static_cast<std::int64_t>(m.columns), true);
  for (std::size_t i = 0; i < m.rows; ++i) {
    for (std::size_t j = 0; j < m.columns; ++j) array.data()[i + j * m.rows] = m(i, j);
  }
  lua_setfield(L, -2, key);
}

// One row each: real and imaginary part.
void set_roots(lua_State* L, const char* key, const std::vector<std::complex<double>>& roots) {
  DenseMatrix m(roots.size(), 2);
  for (std::size_t i = 0; i < roots.size(); ++i) m(i, 0) = roots[i].real(), m(i, 1) = roots[i].imag();
  set_matrix(L, key, m);
}

void set_texts(lua_State* L, const char* key, const std::vector<std::string>& texts) {
  lua_newtable(L);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    push_text(L, texts[i]);
    lua_rawseti(L, -2, static_cast<lua_Integer>(i) + 1);
  }
  lua_setfield(L, -2, key);
}

void set_number(lua_State* L, const char* key, std::optional<double> value) {
  if (!value) return;
  lua_pushnumber(L, *value);
  lua_setfield(L, -2, key);
}

[[noreturn]] void fail(Session& session, const Report& report) {
  throw InputError(to_text(report, session.options.colour));
}

int linearise_diagram(lua_State* L) {
  DiagramObject& self = self_argument<DiagramObject>(L, diagram_kind);
  const Options options(L, 2, "the options of linearise",
                        {"inputs", "outputs", "open", "at", "trim", "hold", "frequencies"});
  LineariseRequest request;
  request.set = self.set;
  if (options.push("inputs")) request.inputs = texts_of(L, "inputs");
  if (options.push("outputs")) request.outputs = texts_of(L, "outputs");
  if (options.push("open")) request.open = texts_of(L, "open");
  request.at = options.number("at");
  request.trim = options.flag("trim");
  request.hold = options.flag("hold");
  Session& session = session_of(L);
  session.sandbox.work(L, 10000);
  Report report;
  const auto model = linearise(self.diagram->model_pointer(), request, report);
  if (!model) fail(session, report);
  session.tell(report);
  lua_newtable(L);
  set_texts(L, "states", model->states);
  set_texts(L, "inputs", model->inputs);
  set_texts(L, "outputs", model->outputs);
  set_matrix(L, "A", model->A);
  set_matrix(L, "B", model->B);
  set_matrix(L, "C", model->C);
  set_matrix(L, "D", model->D);
  set_number(L, "period", model->period);
  set_number(L, "time", model->time);
  set_roots(L, "poles", poles(*model));
  if (model->inputs.empty() || model->outputs.empty()) return 1;
  set_roots(L, "zeros", zeros(*model));
  if (model->inputs.size() != 1 || model->outputs.size() != 1) return 1;
  const Margins m = margins(*model);
  set_number(L, "gain_margin", m.gain);
  set_number(L, "phase_crossover", m.phase_crossover);
  set_number(L, "phase_margin", m.phase);
  set_number(L, "gain_crossover", m.gain_crossover);
  set_number(L, "delay_margin", m.delay);
  std::vector<double> frequencies = frequencies_for(*model, 400);
  if (options.push("frequencies")) {
    const Array& given = array_argument(L, -1, "frequencies");
    frequencies.assign(given.data(), given.data() + given.size());
    lua_pop(L, 1);
  }
  std::vector<double> real, imaginary;
  for (const double w : frequencies) {
    const std::complex<double> g = response(*model, w).front();
    real.push_back(g.real());
    imaginary.push_back(g.imag());
  }
  lua_newtable(L);
  push_vector(L, frequencies);
  lua_setfield(L, -2, "frequency");
  push_vector(L, real);
  lua_setfield(L, -2, "real");
  push_vector(L, imaginary);
  lua_setfield(L, -2, "imaginary");
  lua_setfield(L, -2, "response");
  return 1;
}

void set_entries(lua_State* L, const char* key, const std::vector<Trim::Entry>& entries) {
  lua_newtable(L);
  for (const Trim::Entry& entry : entries) {
    lua_pushnumber(L, entry.value);
    lua_setfield(L, -2, entry.path.c_str());
  }
  lua_setfield(L, -2, key);
}

int trim_diagram(lua_State* L) {
  DiagramObject& self = self_argument<DiagramObject>(L, diagram_kind);
  const Options options(L, 2, "the options of trim", {"inputs", "outputs", "fix", "at"});
  TrimRequest request;
  request.set = self.set;
  if (options.push("inputs")) {
    for (const std::string& path : texts_of(L, "inputs")) request.inputs.push_back({path});
  }
  if (options.push("outputs")) request.outputs = numbers_of(L, "outputs");
  if (options.push("fix")) request.fixed = numbers_of(L, "fix");
  request.at = options.number("at");
  Session& session = session_of(L);
  session.sandbox.work(L, 10000);
  Report report;
  const auto found = trim(self.diagram->model_pointer(), request, report);
  if (!found) fail(session, report);
  session.tell(report);
  lua_newtable(L);
  set_entries(L, "states", found->states);
  set_entries(L, "inputs", found->inputs);
  set_entries(L, "outputs", found->outputs);
  set_number(L, "residual", found->largest_residual);
  lua_pushboolean(L, found->converged ? 1 : 0);
  lua_setfield(L, -2, "converged");
  push_text(L, found->why);
  lua_setfield(L, -2, "why");
  return 1;
}

}  // namespace

Entries analysis_methods() {
  return {
      {"linearise", guarded<linearise_diagram>,
       "options?: {inputs?: string|string[], outputs?: string|string[], open?: string|string[], at?: number, trim?: "
       "boolean, hold?: boolean, frequencies?: pl.Vector}",
       "table",
       "the linear model: A, B, C, D, states, inputs, outputs, period, poles, zeros; with one input and one output "
       "margins and response"},
      {"trim", guarded<trim_diagram>,
       "options?: {inputs?: string|string[], outputs?: table<string, number>, fix?: table<string, number>, at?: "
       "number}",
       "table", "a rest: states, inputs and outputs by path, residual, converged, why"},
  };
}

}  // namespace plantloop::lua
