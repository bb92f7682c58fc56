// What scripts may call: one table per type from which both the functions and the editors' declarations are made.

#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scripts/host/stack.h"

namespace plantloop::lua {

// Types as the declarations write them: "from: number, n?: integer, ...: number".
struct Entry {
  std::string_view name;
  lua_CFunction function;
  std::string_view parameters;  // without the object of a method
  std::string_view returns;
  std::string_view doc;
  bool also_method = false;  // a function of `pl` that vectors have as a method, too: its first parameter is the vector
};
using Entries = std::vector<Entry>;

struct FieldInfo {
  std::string_view name, type, doc;
};

struct TypeInfo {
  std::string_view name;  // "Run"; "pl" is the module itself, and a small letter begins a table of functions in it
  std::string_view doc;
  Entries entries;
  std::vector<FieldInfo> fields;
};

// The names and types of "from: number, options?: {a: number, b: number}": commas inside braces do not separate.
std::vector<std::pair<std::string, std::string>> split_parameters(std::string_view parameters);
// A table of functions inside the module: `pl.identify`.
bool is_table_of_functions(std::string_view name);

// Every type with its methods, the module and its tables.
const std::vector<TypeInfo>& api();

// The module's functions, by file.
Entries vector_makers();
Entries elementwise_functions();
Entries reductions();
Entries series_functions();
Entries matrix_functions();
Entries vector_methods();
Entries diagram_functions();
Entries diagram_methods();
Entries analysis_methods();  // of diagrams, too
Entries velocity_methods();  // of diagrams: families of models in velocity form
Entries study_functions();   // sweeps and fits
Entries tuning_functions();  // controllers from models and step tests
Entries run_methods();
Entries figure_functions();
Entries figure_methods();
Entries panel_methods();
Entries plot_methods(std::string_view self);
Entries file_functions();

// Of the table pl.identify, by file.
Entries identify_data_functions();
Entries identify_linear_functions();
Entries identify_model_functions();
Entries identify_analysis_functions();
Entries data_methods();
Entries linear_model_methods();
Entries state_space_methods();
Entries regression_model_methods();
Entries identify_learned_functions();
Entries gaussian_process_functions();
Entries learned_model_methods();
Entries identify_state_space_functions();
Entries neural_state_space_methods();
std::vector<FieldInfo> data_fields();
std::vector<FieldInfo> linear_model_fields();
std::vector<FieldInfo> state_space_fields();
std::vector<FieldInfo> regression_model_fields();
std::vector<FieldInfo> learned_model_fields();
std::vector<FieldInfo> neural_state_space_fields();

// Set up metatables of the objects.
void open_vectors(lua_State* L);
void open_diagrams(lua_State* L);
void open_runs(lua_State* L);
void open_figures(lua_State* L);
void open_data(lua_State* L);
void open_linear_models(lua_State* L);
void open_models(lua_State* L);
void open_learned_models(lua_State* L);
void open_neural_state_space(lua_State* L);

// The table `pl`, on the stack.
void push_module(lua_State* L);
// A table with the functions of the entries, on the stack.
void push_functions(lua_State* L, const Entries& entries);

// The globals of a script, built from a list of what is allowed: replaces what is there.
void open_globals(lua_State* L);
void open_strings(lua_State* L);  // fills the table on the stack
void open_tables(lua_State* L);
void open_require(lua_State* L);

}  // namespace plantloop::lua
