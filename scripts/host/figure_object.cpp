// pl.figure: panels, series, reference lines and bands, in the words of diagrams' `figures:`.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "app/figures.h"
#include "engine/base/files.h"
#include "render/error.h"
#include "render/image.h"
#include "render/layout.h"
#include "render/theme.h"
#include "scripts/host/api.h"
#include "scripts/host/figure_options.h"
#include "scripts/host/objects.h"
#include "scripts/host/picture.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

// [lower, upper], where one may be left out by a not-a-number.
Limits limits_on_top(lua_State* L) {
  const Array& ends = vector_argument(L, -1, "limits");
  if (ends.size() != 2) throw ScriptError("'limits' are two numbers, {lower, upper}");
  Limits limits;
  if (ends.data()[0] == ends.data()[0]) limits.lower = ends.data()[0];
  if (ends.data()[1] == ends.data()[1]) limits.upper = ends.data()[1];
  return limits;
}

Scale scale_of(const std::string& text) {
  if (text == "linear") return Scale::linear;
  if (text == "log") return Scale::log;
  if (text == "symlog") return Scale::symlog;
  throw ScriptError(fmt::format("'scale' must be linear, log or symlog, it is '{}'", text));
}

// An axis: its label, or {label = ..., limits = {0, 1}, scale = "log"}.
void read_axis(lua_State* L, const Options& options, const char* key, Axis& axis) {
  if (!options.push(key)) return;
  if (lua_type(L, -1) == LUA_TSTRING) {
    axis.label = lua_tostring(L, -1);
  } else {
    if (!lua_istable(L, -1)) options.wrong(key, "a label or {label = ..., limits = {...}}");
    const Options own(L, -1, fmt::format("the axis '{}'", key), {"label", "limits", "scale", "threshold"});
    axis.label = own.text("label", axis.label);
    if (own.has("scale")) axis.scale = scale_of(own.text("scale"));
    axis.threshold = own.number("threshold").value_or(axis.threshold);
    if (own.push("limits")) {
      axis.limits = limits_on_top(L);
      lua_pop(L, 1);
    }
  }
  lua_pop(L, 1);
}

std::optional<Color> color_of(const Options& options) {
  if (!options.has("color")) return std::nullopt;
  const std::string text = options.text("color");
  const auto color = parse_color(text);
  if (!color) throw ScriptError(fmt::format("there is no colour '{}': it is a name, as blue, or #RRGGBB", text));
  return color;
}

LineStyle line_style(const Options& options, LineStyle fallback) {
  const std::string style = options.text("style");
  if (style.empty()) return fallback;
  if (style == "solid") return LineStyle::solid;
  if (style == "dashed") return LineStyle::dashed;
  if (style == "dotted") return LineStyle::dotted;
  if (style == "dashdot") return LineStyle::dashdot;
  options.wrong("style", "solid, dashed, dotted or dashdot");
}

Marker marker_of(const Options& options) {
  constexpr std::array<std::string_view, 10> names{"none",     "dot",   "ring", "square", "diamond",
                                                   "triangle", "cross", "plus", "dash",   "tick"};
  const auto found = std::find(names.begin(), names.end(), options.text("marker", "none"));
  if (found == names.end()) {
    options.wrong("marker", "none, dot, ring, square, diamond, triangle, cross, plus, dash or tick");
  }
  return static_cast<Marker>(found - names.begin());
}

const std::vector<std::string> reference_keys{"y", "x", "label", "style", "color"};
const std::vector<std::string> shade_keys{"lower", "upper", "from", "until", "label", "color"};
const std::vector<std::string> callout_keys{"x", "y", "label", "marker", "color", "right"};
const std::vector<std::string> inset_keys{"x", "y", "limits", "place"};
const std::vector<std::string> panel_keys{"title", "x",     "y",     "right", "limits",
                                          "scale", "lines", "bands", "equal", "height"};

ReferenceLine reference_of(lua_State* L, int index) {
  const Options options(L, index, "a reference line", reference_keys);
  if (options.has("x") == options.has("y")) throw ScriptError("a reference line has either x or y, as in {y = 1.5}");
  const bool vertical = options.has("x");
  return {.axis = vertical ? ReferenceLine::x : ReferenceLine::y,
          .at = *options.number(vertical ? "x" : "y"),
          .label = options.text("label"),
          .style = line_style(options, LineStyle::dashed),
          .color = color_of(options)};
}

ReferenceBand shade_of(lua_State* L, int index) {
  const Options options(L, index, "a band", shade_keys);
  return {.lower = options.number("lower"),
          .upper = options.number("upper"),
          .from = options.number("from"),
          .until = options.number("until"),
          .label = options.text("label"),
          .color = color_of(options)};
}

// Calls read(index) for each table of the list under the key.
template <typename Read>
void for_list(lua_State* L, const Options& options, const char* key, Read read) {
  if (!options.push(key)) return;
  if (!lua_istable(L, -1)) options.wrong(key, "a list of tables");
  for (lua_Integer i = 1; lua_rawgeti(L, -1, i) != LUA_TNIL; ++i) {
    read(lua_gettop(L));
    lua_pop(L, 1);
  }
  lua_pop(L, 2);
}

// What both pl.figure and figure:panel understand; `x` only of a panel, the figure's own is shared.
void read_panel(lua_State* L, const Options& options, Panel& panel) {
  read_axis(L, options, "y", panel.y);
  read_axis(L, options, "right", panel.right);
  if (options.push("limits")) {
    panel.y.limits = limits_on_top(L);
    lua_pop(L, 1);
  }
  if (options.has("scale")) panel.y.scale = scale_of(options.text("scale"));
  panel.equal = options.flag("equal");
  for_list(L, options, "lines", [&](int index) { panel.lines.push_back(reference_of(L, index)); });
  for_list(L, options, "bands", [&](int index) { panel.bands.push_back(shade_of(L, index)); });
}

int make(lua_State* L) {
  std::vector<std::string> keys = panel_keys;
  keys.insert(keys.end(), {"theme", "width", "dpi", "columns", "share_y"});
  const Options options(L, 1, "the options of figure", keys);
  auto figure = std::make_shared<Figure>();
  FigureObject object{figure, {}};
  figure->title = options.text("title");
  figure->theme = options.text("theme", figure->theme);
  if (find_theme(figure->theme) == nullptr) {
    throw ScriptError(fmt::format("there is no theme '{}'{}", figure->theme, suggestion(figure->theme, theme_names())));
  }
  figure->width = options.number("width").value_or(figure->width);
  figure->height = options.number("height").value_or(figure->height);
  figure->dpi = options.number("dpi").value_or(figure->dpi);
  const double columns = options.number("columns").value_or(1);
  if (!(columns >= 1 && columns <= 20)) throw ScriptError("'columns' must be a whole number from 1 to 20");
  figure->columns = static_cast<int>(columns);
  figure->share_y = options.flag("share_y");
  read_axis(L, options, "x", figure->x);
  read_panel(L, options, object.first);
  push_object(L, figure_kind, std::move(object));
  return 1;
}

int panel(lua_State* L) {
  FigureObject& self = self_argument<FigureObject>(L, figure_kind);
  const Options options(L, 2, "the options of panel", panel_keys);
  Panel made;
  made.title = options.text("title");
  made.height = options.number("height").value_or(1);
  if (!(made.height > 0)) throw ScriptError("'height' must be greater than 0: it is relative to the other panels");
  if (options.has("x")) {
    made.x = self.figure->x;
    read_axis(L, options, "x", *made.x);
  }
  read_panel(L, options, made);
  self.figure->add_panel(std::move(made));
  push_object(L, panel_kind, PanelObject{self.figure, self.figure->panels.size() - 1});
  return 1;
}

Panel& panel_of(lua_State* L) { return panel_place(L).get(); }

void settle_look(const Options& options, Series& series) {
  const std::string label = series.look.label;
  series.look = read_look(options);
  if (!options.has("label")) series.look.label = label;
  apply_style(options.text("style"), series.look, series.kind);
}

int add(lua_State* L, Panel& panel, const Options& options, Series series) {
  const double cost = static_cast<double>(series.x.size() + series.y.size() + series.lower.size());
  session_of(L).sandbox.work(L, cost);
  const bool right = options.flag("right");
  (right ? panel.right_series : panel.series).push_back(std::move(series));
  lua_settop(L, 1);
  return 1;  // the figure or panel again
}

void check_lengths(const std::vector<double>& x, const std::vector<double>& y, const char* name) {
  if (x.size() != y.size()) throw ScriptError(fmt::format("x has {} numbers and {} has {}", x.size(), name, y.size()));
}

int add_curve(lua_State* L, Series::Kind kind, bool only_markers) {
  Panel& panel = panel_of(L);
  const Options options(L, 4, "the options of a curve", look_keys());
  Series series{.kind = kind, .x = numbers_argument(L, 2, "x"), .y = numbers_argument(L, 3, "y")};
  check_lengths(series.x, series.y, "y");
  settle_look(options, series);
  if (only_markers) series = marker_series(std::move(series.x), std::move(series.y), std::move(series.look));
  return add(L, panel, options, std::move(series));
}

int line(lua_State* L) { return add_curve(L, Series::Kind::line, false); }
int stairs(lua_State* L) { return add_curve(L, Series::Kind::stairs, false); }
int markers(lua_State* L) { return add_curve(L, Series::Kind::line, true); }

int band(lua_State* L) {
  Panel& panel = panel_of(L);
  const Options options(L, 5, "the options of a band", look_keys());
  Series series{.kind = Series::Kind::band,
                .x = numbers_argument(L, 2, "x"),
                .y = numbers_argument(L, 4, "upper"),
                .lower = numbers_argument(L, 3, "lower")};
  check_lengths(series.x, series.lower, "lower");
  check_lengths(series.x, series.y, "upper");
  settle_look(options, series);
  return add(L, panel, options, std::move(series));
}

int signal(lua_State* L) {
  Panel& panel = panel_of(L);
  check_self(L, 2, run_kind);
  const RunObject& run = **static_cast<RunPointer*>(lua_touserdata(L, 2));
  const std::string name = text_argument(L, 3, "column");
  const Options options(L, 4, "the options of a curve", look_keys());
  const std::size_t column = column_of(run, name);
  Series series = series_of(run.recording(), column, {.label = name});
  settle_look(options, series);
  Axis& axis = options.flag("right") ? panel.right : panel.y;
  if (axis.label.empty() && panel.series.empty()) axis.label = label_of(run.recording().columns[column]);
  return add(L, panel, options, std::move(series));
}

int reference(lua_State* L) {
  Panel& panel = panel_of(L);
  panel.lines.push_back(reference_of(L, 2));
  lua_settop(L, 1);
  return 1;
}

int shade(lua_State* L) {
  Panel& panel = panel_of(L);
  panel.bands.push_back(shade_of(L, 2));
  lua_settop(L, 1);
  return 1;
}

int annotate(lua_State* L) {
  Panel& panel = panel_of(L);
  const Options options(L, 2, "a remark", callout_keys);
  if (!options.has("x") || !options.has("y"))
    throw ScriptError("a remark stands at x and y, as in {x = 1, y = 2, label = \"peak\"}");
  Callout callout{.x = *options.number("x"), .y = *options.number("y"), .label = options.text("label")};
  if (options.has("marker")) callout.marker = marker_of(options);
  callout.color = color_of(options);
  callout.right = options.flag("right");
  panel.callouts.push_back(std::move(callout));
  lua_settop(L, 1);
  return 1;
}

int inset(lua_State* L) {
  const PanelPlace place = panel_place(L);
  if (place.inset) throw ScriptError("an inset has no insets");
  const Options options(L, 2, "the options of inset", inset_keys);
  Panel made;
  made.x = Axis{};
  read_axis(L, options, "x", *made.x);
  read_axis(L, options, "y", made.y);
  if (options.push("limits")) {
    made.y.limits = limits_on_top(L);
    lua_pop(L, 1);
  }
  if (options.push("place")) {
    const Array& where = vector_argument(L, -1, "place");
    if (where.size() != 4) throw ScriptError("'place' is four parts of the panel, {left, bottom, width, height}");
    made.place = Panel::Place{where.data()[0], where.data()[1], where.data()[2], where.data()[3]};
    lua_pop(L, 1);
  }
  place.get().insets.push_back(std::move(made));
  push_object(L, panel_kind, PanelObject{place.figure, place.panel, place.get().insets.size() - 1});
  return 1;
}

int save(lua_State* L) {
  const FigureObject& self = self_argument<FigureObject>(L, figure_kind);
  const std::string path = text_argument(L, 2, "path");
  Figure figure = *self.figure;
  if (figure.panels.empty()) figure.add_panel(self.first);
  session_of(L).sandbox.work(L, 10000);
  push_text(L, save_picture(session_of(L), figure, path));
  return 1;
}

// Upvalues: the methods, and what the object is called.
int index(lua_State* L) {
  const std::string name = text_argument(L, 2, "name");
  if (lua_getfield(L, lua_upvalueindex(1), name.c_str()) != LUA_TNIL) return 1;
  std::vector<std::string> names;
  lua_pushnil(L);
  while (lua_next(L, lua_upvalueindex(1)) != 0) {
    lua_pop(L, 1);
    names.emplace_back(lua_tostring(L, -1));
  }
  std::sort(names.begin(), names.end());
  throw ScriptError(
      fmt::format("a {} has no '{}'{}", lua_tostring(L, lua_upvalueindex(2)), name, suggestion(name, names)));
}

Entries series_methods(std::string_view self) {
  Entries entries = plot_methods(self);
  const std::string_view look =
      "x: pl.Vector, y: pl.Vector, look?: {label?: string, style?: string, marker?: string, color?: string, width?: "
      "number, right?: boolean}";
  const Entries own{
      {"line", guarded<line>, look, self, "adds a curve, straight from point to point"},
      {"stairs", guarded<stairs>, look, self, "adds a curve that holds each value until the next"},
      {"markers", guarded<markers>, look, self, "adds points without a line"},
      {"band", guarded<band>,
       "x: pl.Vector, lower: pl.Vector, upper: pl.Vector, look?: {label?: string, color?: string, right?: boolean}",
       self, "adds the area between two curves"},
      {"signal", guarded<signal>,
       "run: pl.Run, column: string, look?: {label?: string, style?: string, marker?: string, color?: string, width?: "
       "number, right?: boolean}",
       self, "adds a run's column over time, sampled ones as stairs, with its name and unit"},
      {"reference", guarded<reference>,
       "line: {y?: number, x?: number, label?: string, style?: string, color?: string}", self,
       "adds a thin line across the panel"},
      {"annotate", guarded<annotate>,
       "remark: {x: number, y: number, label?: string, marker?: string, color?: string, right?: boolean}", self,
       "marks a point and says something about it where there is room"},
      {"inset", guarded<inset>, "options?: {x?: string|table, y?: string|table, limits?: number[], place?: number[]}",
       "pl.Panel",
       "a small panel inside this one, by default where the least is drawn; place is {left, bottom, width, height}, "
       "parts of the panel"},
      {"shade", guarded<shade>,
       "band: {lower?: number, upper?: number, from?: number, until?: number, label?: string, color?: string}", self,
       "tints a part of the panel"},
  };
  entries.insert(entries.begin(), own.begin(), own.end());
  return entries;
}

}  // namespace

Panel& PanelPlace::get() const {
  Panel& outer = figure->panels[panel];
  return inset ? outer.insets[*inset] : outer;
}

PanelPlace panel_place(lua_State* L) {
  if (const auto* panel = test_object<PanelObject>(L, 1, panel_kind))
    return {panel->figure, panel->index, panel->inset};
  FigureObject& self = self_argument<FigureObject>(L, figure_kind);
  if (self.figure->panels.empty()) self.figure->add_panel(self.first);
  return {self.figure, 0, std::nullopt};
}

const std::vector<std::string>& look_keys() {
  static const std::vector<std::string> keys{"label", "style", "marker", "color", "width", "opacity", "size", "right"};
  return keys;
}

SeriesLook read_look(const Options& options) {
  SeriesLook look;
  look.label = options.text("label");
  look.marker = marker_of(options);
  look.color = color_of(options);
  look.width = options.number("width").value_or(0);
  look.opacity = options.number("opacity").value_or(1);
  look.size = options.number("size").value_or(0);
  Series::Kind kind{};
  if (!apply_style(options.text("style"), look, kind))
    options.wrong("style", "solid, dashed, dotted, dashdot, none, points, line_points or steps");
  return look;
}

std::string save_picture(const Session& session, const Figure& figure, const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  const std::vector<std::string> formats = picture_formats();
  if (ending.empty() || std::find(formats.begin(), formats.end(), ending.substr(1)) == formats.end()) {
    throw ScriptError(fmt::format("cannot draw '{}': the name must end in .{}", path, fmt::join(formats, " or .")));
  }
  const FileResult place = session.writable(path);
  if (!place.ok()) throw ScriptError(fmt::format("cannot write '{}': {}", path, place.error));
  const std::vector<std::uint8_t> bytes = picture(layout(figure), ending.substr(1));
  const std::string error = write_file(place.value, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (!error.empty()) throw ScriptError(fmt::format("cannot write '{}': {}", path, error));
  return place.value;
}

Entries figure_functions() {
  return {
      {"figure", guarded<make>,
       "options?: {title?: string, x?: string|table, y?: string|table, right?: string|table, limits?: number[], "
       "scale?: "
       "string, lines?: table[], bands?: table[], equal?: boolean, theme?: string, width?: number, height?: number, "
       "dpi?: "
       "number, columns?: integer, share_y?: boolean}",
       "pl.Figure",
       "a new figure. x and y are labels, or {label = ..., limits = {0, 1}, scale = \"log\"}; sizes in mm"},
  };
}

Entries figure_methods() {
  Entries entries = series_methods("pl.Figure");
  entries.push_back({"panel", guarded<panel>,
                     "options?: {title?: string, x?: string|table, y?: string|table, right?: string|table, limits?: "
                     "number[], scale?: string, lines?: table[], bands?: table[], equal?: boolean, height?: number}",
                     "pl.Panel", "adds a panel below; with an x of its own it does not share the figure's"});
  entries.push_back({"save", guarded<save>, "path: string", "string",
                     "draws into a .png, .svg or .pdf file below the working directory; gives the path"});
  return entries;
}

Entries panel_methods() { return series_methods("pl.Panel"); }

void open_figures(lua_State* L) {
  const auto open = [L](const char* kind, const Entries& methods, lua_CFunction destroy) {
    luaL_newmetatable(L, kind);
    lua_pushcfunction(L, destroy);
    lua_setfield(L, -2, "__gc");
    push_text(L, kind);
    lua_setfield(L, -2, "__metatable");
    push_functions(L, methods);
    push_text(L, kind);
    lua_pushcclosure(L, guarded<index>, 2);
    lua_setfield(L, -2, "__index");
    lua_pop(L, 1);
  };
  open(figure_kind, figure_methods(), destroy_object<FigureObject>);
  open(panel_kind, panel_methods(), destroy_object<PanelObject>);
}

}  // namespace plantloop::lua
