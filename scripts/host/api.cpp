// The parts of the interface in one place, registered and printed from the same tables.

#include "scripts/host/api.h"

#include <fmt/format.h>

#include <string>

#include "scripts/host/session.h"

namespace plantloop::lua {
namespace {

Entries all_of(std::initializer_list<Entries> parts) {
  Entries all;
  for (const Entries& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

std::vector<TypeInfo> make_api() {
  return {
      {"pl",
       "Plantloop for experiments: local pl = require \"plantloop\"",
       all_of({diagram_functions(), study_functions(), tuning_functions(), figure_functions(), file_functions(),
               vector_makers(), elementwise_functions(), reductions(), series_functions(), matrix_functions()}),
       {{"project", "string",
         "the project's folder: the nearest one upwards from the script with .git or plantloop.yaml"},
        {"pi", "number", "3.14159..."},
        {"inf", "number", "infinity"},
        {"nan", "number", "not a number"}}},
      {"Vector",
       "Numbers with arithmetic, element by element. x[i] from 1, #x; of a matrix A[i] is a row, A(i, k) an element.",
       vector_methods(),
       {}},
      {"Diagram",
       "A diagram, to be run any number of times.",
       diagram_methods(),
       {{"title", "string", "as in the file"},
        {"path", "string", "of the file"},
        {"parameters", "table<string, string>", "the top-level parameters as written"}}},
      {"Run",
       "The result of a run. run.y, run[\"loop.y\"], run[\"xh.3\"] are its columns, run.xh is a vector's matrix, "
       "run.time the time; methods are called with ':' and may share a column's name.",
       run_methods(),
       {{"time", "pl.Vector", "s; a jump has two rows of equal time"}, {"[string]", "pl.Vector", "a column"}}},
      {"Figure", "A figure: one panel, or several below each other.", figure_methods(), {}},
      {"Panel", "One panel of a figure.", panel_methods(), {}},
      {"identify",
       "Models from data.",
       all_of({identify_data_functions(), identify_linear_functions(), identify_model_functions(),
               identify_learned_functions(), gaussian_process_functions(), identify_state_space_functions(),
               identify_analysis_functions()}),
       {}},
      {"DataSet", "Measured inputs u and outputs y of one process, in one or more experiments.", data_methods(),
       data_fields()},
      {"LinearModel", "A y = q^-delay (B/F) u + (C/D) v, polynomials in the delay operator.", linear_model_methods(),
       linear_model_fields()},
      {"StateSpaceModel", "x(k+1) = A x + B u, y = C x + D u.", state_space_methods(), state_space_fields()},
      {"RegressionModel", "A NARX model that is linear in its parameters.", regression_model_methods(),
       regression_model_fields()},
      {"LearnedModel", "A network, local models or a Gaussian process from regressors to outputs.",
       learned_model_methods(), learned_model_fields()},
      {"NeuralStateSpace", "x(k+1) = f(x, u), y = g(x, u), both of them networks.", neural_state_space_methods(),
       neural_state_space_fields()},
  };
}

std::string function_stub(const std::string& owner, char separator, const Entry& entry, bool skip_first) {
  std::string text = fmt::format("\n---{}\n", entry.doc);
  std::string names;
  for (const auto& [name, type] : split_parameters(entry.parameters)) {
    if (skip_first) {
      skip_first = false;
      continue;
    }
    text += fmt::format("---@param {} {}\n", name, type);
    const bool optional = name.ends_with('?');
    names += (names.empty() ? "" : ", ") + (optional ? name.substr(0, name.size() - 1) : name);
  }
  if (!entry.returns.empty()) text += fmt::format("---@return {}\n", entry.returns);
  return text + fmt::format("function {}{}{}({}) end\n", owner, separator, entry.name, names);
}

}  // namespace

std::vector<std::pair<std::string, std::string>> split_parameters(std::string_view parameters) {
  std::vector<std::pair<std::string, std::string>> list;
  std::size_t begin = 0;
  int depth = 0;
  for (std::size_t i = 0; i <= parameters.size(); ++i) {
    const char c = i < parameters.size() ? parameters[i] : ',';
    if (c == '{' || c == '<' || c == '(') ++depth;
    if (c == '}' || c == '>' || c == ')') --depth;
    if (c != ',' || depth > 0 || i == begin) continue;
    const std::string_view one = parameters.substr(begin, i - begin);
    const std::size_t colon = one.find(": ");
    list.emplace_back(one.substr(0, colon), one.substr(colon + 2));
    begin = i + 2;
  }
  return list;
}

bool is_table_of_functions(std::string_view name) { return name != "pl" && name[0] >= 'a' && name[0] <= 'z'; }

const std::vector<TypeInfo>& api() {
  static const std::vector<TypeInfo> types = make_api();
  return types;
}

void push_functions(lua_State* L, const Entries& entries) {
  lua_createtable(L, 0, static_cast<int>(entries.size()));
  for (const Entry& entry : entries) {
    push_text(L, entry.name);
    // A function knows its own name: one serves all plot types.
    push_text(L, entry.name);
    lua_pushcclosure(L, entry.function, 1);
    lua_rawset(L, -3);
  }
}

void push_module(lua_State* L) {
  for (const TypeInfo& type : api()) {
    if (type.name == "pl") push_functions(L, type.entries);
  }
  for (const TypeInfo& type : api()) {
    if (!is_table_of_functions(type.name)) continue;
    push_functions(L, type.entries);
    lua_setfield(L, -2, std::string(type.name).c_str());
  }
  push_text(L, session_of(L).project);
  lua_setfield(L, -2, "project");
  lua_pushnumber(L, 3.14159265358979323846);
  lua_setfield(L, -2, "pi");
  lua_pushnumber(L, HUGE_VAL);
  lua_setfield(L, -2, "inf");
  lua_pushnumber(L, NAN);
  lua_setfield(L, -2, "nan");
}

}  // namespace plantloop::lua

namespace plantloop {

std::string lua_stubs() {
  std::string text = "---@meta plantloop\n-- Plantloop for editors: made from the program's own table of functions.\n";
  const lua::Entries* functions = nullptr;
  for (const lua::TypeInfo& type : lua::api()) {
    const bool is_module = type.name == "pl";
    if (is_module) functions = &type.entries;
    const std::string name = is_module ? "pl" : fmt::format("pl.{}", type.name);
    text += fmt::format("\n---{}\n---@class {}\n", type.doc, name);
    for (const lua::FieldInfo& field : type.fields) {
      text += fmt::format("---@field {} {} {}\n", field.name, field.type, field.doc);
    }
    if (type.name == "Vector") {
      for (const char* op : {"add", "sub", "mul", "div", "pow", "mod"}) {
        text += fmt::format("---@operator {}(pl.Vector|number): pl.Vector\n", op);
      }
      text +=
          "---@operator unm: pl.Vector\n---@operator len: integer\n---@field [integer] number|pl.Vector an element\n";
    }
    const std::string local = is_module ? "pl" : std::string(type.name);
    text += fmt::format("local {} = {{}}\n", local);
    const char separator = is_module || lua::is_table_of_functions(type.name) ? '.' : ':';
    for (const lua::Entry& entry : type.entries) text += lua::function_stub(local, separator, entry, false);
    if (lua::is_table_of_functions(type.name)) text += fmt::format("pl.{} = {}\n", name.substr(3), local);
    if (type.name != "Vector") continue;
    for (const lua::Entry& entry : *functions) {
      if (entry.also_method) text += lua::function_stub(local, ':', entry, true);
    }
  }
  return text + "\nreturn pl\n";
}

}  // namespace plantloop
