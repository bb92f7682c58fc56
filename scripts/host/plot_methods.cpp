// One method of figures and panels for each plot type of render/plots, read off its declaration.

#include <fmt/format.h>

#include <list>

#include "render/error.h"
#include "render/plots/plot.h"
#include "scripts/host/api.h"
#include "scripts/host/figure_options.h"
#include "scripts/host/objects.h"
#include "scripts/host/session.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

GridValues grid_argument(lua_State* L, int index, std::string_view name) {
  const Array& a = array_argument(L, index, name);
  // A plain vector is one column.
  GridValues grid{static_cast<std::size_t>(a.rows), static_cast<std::size_t>(a.columns), {}};
  for (std::int64_t row = 0; row < a.rows; ++row)
    for (std::int64_t column = 0; column < a.columns; ++column) grid.values.push_back(a.data()[row + column * a.rows]);
  return grid;
}

std::vector<std::string> texts_on_top(lua_State* L, const Options& options, const char* key) {
  std::vector<std::string> texts;
  if (lua_type(L, -1) == LUA_TSTRING) return {lua_tostring(L, -1)};
  if (!lua_istable(L, -1)) options.wrong(key, "a list of texts");
  for (lua_Integer i = 1; lua_rawgeti(L, -1, i) != LUA_TNIL; ++i) {
    if (!lua_isstring(L, -1)) options.wrong(key, "a list of texts");
    texts.emplace_back(lua_tostring(L, -1));
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
  return texts;
}

bool is_data(const PlotInput& input) {
  return input.kind == PlotInput::Kind::column || input.kind == PlotInput::Kind::grid;
}

PlotValue data_argument(lua_State* L, int index, const PlotInput& input) {
  if (input.kind == PlotInput::Kind::grid) return grid_argument(L, index, input.name);
  return numbers_argument(L, index, input.name);
}

// Numbers, or options? A table is options when its keys are names.
bool holds_numbers(lua_State* L, int index) {
  if (!lua_istable(L, index)) return is_given(L, index);
  lua_pushnil(L);
  if (lua_next(L, index) == 0) return true;
  const bool named = lua_type(L, -2) == LUA_TSTRING;
  lua_pop(L, 2);
  return !named;
}

PlotValue option(lua_State* L, const Options& options, const PlotInput& input) {
  const std::string key(input.name);
  switch (input.kind) {
    case PlotInput::Kind::number:
      return *options.number(key.c_str());
    case PlotInput::Kind::flag:
      return options.flag(key.c_str());
    case PlotInput::Kind::choice:
    case PlotInput::Kind::text:
      return options.text(key.c_str());
    default:
      break;
  }
  options.push(key.c_str());
  PlotValue value = input.kind == PlotInput::Kind::texts ? PlotValue(texts_on_top(L, options, key.c_str()))
                                                         : data_argument(L, lua_gettop(L), input);
  lua_pop(L, 1);
  return value;
}

double work_of(const PlotValue& value) {
  if (const auto* column = std::get_if<std::vector<double>>(&value)) return static_cast<double>(column->size());
  if (const auto* grid = std::get_if<GridValues>(&value)) return static_cast<double>(grid->values.size());
  return 1;
}

// figure:stem(x, y, {base = 0}): the numbers in the order of the declaration, then options by name. The plot type is
// the function's own name.
int use_plot(lua_State* L) {
  const Plot& plot = *find_plot(lua_tostring(L, lua_upvalueindex(1)));
  const PanelPlace place = panel_place(L);
  Given given(plot);
  double work = 0;
  try {
    int argument = 2;
    for (const PlotInput& input : plot.inputs()) {
      if (!is_data(input) || !holds_numbers(L, argument)) break;
      PlotValue value = data_argument(L, argument++, input);
      work += work_of(value);
      given.set(input.name, std::move(value));
    }
    std::vector<std::string> known = look_keys();
    for (const PlotInput& input : plot.inputs()) known.emplace_back(input.name);
    const Options options(L, argument, fmt::format("the options of {}", plot.name()), known);
    for (const PlotInput& input : plot.inputs()) {
      if (!options.has(std::string(input.name).c_str())) continue;
      PlotValue value = option(L, options, input);
      work += work_of(value);
      given.set(input.name, std::move(value));
    }
    Series::Kind kind{};
    given.look = read_look(L, options, kind);
    given.right = options.flag("right");
    given.check();
    session_of(L).sandbox.work(L, 10 * work);
    Canvas canvas = place.inset ? Canvas(*place.figure, place.panel, *place.inset) : Canvas(*place.figure, place.panel);
    plot.draw(canvas, given);
  } catch (const RenderError& e) {
    throw ScriptError(e.what());
  }
  lua_settop(L, 1);
  return 1;  // the figure or panel again
}

std::string_view type_of(const PlotInput& input) {
  switch (input.kind) {
    case PlotInput::Kind::number:
      return "number";
    case PlotInput::Kind::flag:
      return "boolean";
    case PlotInput::Kind::texts:
      return "string[]";
    case PlotInput::Kind::choice:
    case PlotInput::Kind::text:
      return "string";
    default:
      return "pl.Vector";
  }
}

// "x: pl.Vector, y: pl.Vector, options?: {base?: number, label?: string, ...}"
std::string parameters_of(const Plot& plot) {
  std::string positional, named;
  bool leading = true;
  for (const PlotInput& input : plot.inputs()) {
    leading = leading && is_data(input) && input.need == Need::needed;
    if (leading)
      positional += fmt::format("{}: pl.Vector, ", input.name);
    else
      named += fmt::format("{}?: {}, ", input.name, type_of(input));
  }
  return fmt::format("{}options?: {{{}{}", positional, named, look_type().substr(1));
}

}  // namespace

Entries plot_methods(std::string_view self) {
  static const std::list<std::string> parameters = [] {
    std::list<std::string> all;
    for (const Plot* plot : plots()) all.push_back(parameters_of(*plot));
    return all;
  }();
  Entries entries;
  auto own = parameters.begin();
  for (const Plot* plot : plots()) entries.push_back({plot->name(), guarded<use_plot>, *own++, self, plot->summary()});
  return entries;
}

}  // namespace plantloop::lua
