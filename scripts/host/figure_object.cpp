// pl.figure: panels, series, reference lines and bands, in the words of diagrams' `figures:`.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "app/figures.h"
#include "app/figures/parts.h"
#include "engine/base/files.h"
#include "render/error.h"
#include "render/image.h"
#include "render/layout.h"
#include "scripts/host/api.h"
#include "scripts/host/figure_options.h"
#include "scripts/host/figure_words.h"
#include "scripts/host/objects.h"
#include "scripts/host/picture.h"
#include "scripts/host/vector.h"

namespace plantloop::lua {
namespace {

const FigureEntry* given_axis(const FigureBlock& says, std::string_view name) {
  const FigureEntry* axis = says.find(name);
  return axis && axis->word->kind == FigureWord::Kind::axis ? axis : nullptr;
}

void set_script_axis(const FigureBlock& says, std::string_view name, Axis& axis) {
  const FigureEntry* given = given_axis(says, name);
  if (!given) return;
  if (given->parts.empty())
    axis.label = given->text;
  else
    set_axis(axis, given->parts[0], plain_number);
}

// What pl.figure and figure:panel understand alike.
void set_script_panel(Panel& panel, const FigureBlock& says, const Axis& shared) {
  set_script_axis(says, "y", panel.y);
  set_script_axis(says, "right", panel.right);
  set_panel(panel, says, shared, plain_number);
}

ReferenceLine reference_of(lua_State* L, int index) {
  const FigureBlock says = block_at(L, index, "a reference line", line_words());
  if (!says.find("x") == !says.find("y")) throw ScriptError("a reference line has either x or y, as in {y = 1.5}");
  return line_of(says, plain_number);
}

int make(lua_State* L) {
  const FigureBlock says = block_at(L, 1, "the options of figure", script_figure_words());
  auto figure = std::make_shared<Figure>();
  FigureObject object{figure, {}};
  set_figure(*figure, says, plain_number);
  FigureBlock first = says;
  std::erase_if(first.entries, [](const FigureEntry& e) { return picture_words().find(e.word->name) != nullptr; });
  set_script_panel(object.first, first, figure->x);
  push_object(L, figure_kind, std::move(object));
  return 1;
}

int panel(lua_State* L) {
  FigureObject& self = self_argument<FigureObject>(L, figure_kind);
  const FigureBlock says = block_at(L, 2, "the options of panel", script_panel_words());
  Panel made;
  if (given_axis(says, "x")) {
    made.x = self.figure->x;
    set_script_axis(says, "x", *made.x);
  }
  set_script_panel(made, says, self.figure->x);
  self.figure->add_panel(std::move(made));
  push_object(L, panel_kind, PanelObject{self.figure, self.figure->panels.size() - 1});
  return 1;
}

Panel& panel_of(lua_State* L) { return panel_place(L).get(); }

void settle_look(lua_State* L, const Options& options, Series& series) {
  const std::string label = series.look.label;
  series.look = read_look(L, options, series.kind);
  if (!options.has("label")) series.look.label = label;
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
  settle_look(L, options, series);
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
  settle_look(L, options, series);
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
  settle_look(L, options, series);
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
  panel.bands.push_back(band_of(block_at(L, 2, "a band", band_words()), plain_number));
  lua_settop(L, 1);
  return 1;
}

int annotate(lua_State* L) {
  Panel& panel = panel_of(L);
  const FigureBlock says = block_at(L, 2, "a remark", remark_words());
  if (!says.find("x") || !says.find("y"))
    throw ScriptError("a remark stands at x and y, as in {x = 1, y = 2, label = \"peak\"}");
  panel.callouts.push_back(remark_of(says, plain_number));
  lua_settop(L, 1);
  return 1;
}

int inset(lua_State* L) {
  const PanelPlace place = panel_place(L);
  if (place.inset) throw ScriptError("an inset has no insets");
  const FigureBlock says = block_at(L, 2, "the options of inset", script_inset_words());
  Panel made;
  made.x = Axis{};
  set_script_axis(says, "x", *made.x);
  set_script_panel(made, says, Axis{});
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
  static const std::string look = "x: pl.Vector, y: pl.Vector, look?: " + look_type();
  static const std::string area = "x: pl.Vector, lower: pl.Vector, upper: pl.Vector, look?: " + look_type();
  static const std::string shown = "run: pl.Run, column: string, look?: " + look_type();
  static const std::string line_type = "line: " + table_type(line_words());
  static const std::string remark = "remark: " + table_type(remark_words());
  static const std::string small = "options?: " + table_type(script_inset_words());
  static const std::string tint = "band: " + table_type(band_words());
  const Entries own{
      {"line", guarded<line>, look, self, "adds a curve, straight from point to point"},
      {"stairs", guarded<stairs>, look, self, "adds a curve that holds each value until the next"},
      {"markers", guarded<markers>, look, self, "adds points without a line"},
      {"band", guarded<band>, area, self, "adds the area between two curves"},
      {"signal", guarded<signal>, shown, self,
       "adds a run's column over time, sampled ones as stairs, with its name and unit"},
      {"reference", guarded<reference>, line_type, self, "adds a thin line across the panel"},
      {"annotate", guarded<annotate>, remark, self, "marks a point and says something about it where there is room"},
      {"inset", guarded<inset>, small, "pl.Panel",
       "a small panel inside this one, by default where the least is drawn; place is {left, bottom, width, height}, "
       "parts of the panel"},
      {"shade", guarded<shade>, tint, self, "tints a part of the panel"},
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
  static const std::vector<std::string> keys = [] {
    std::vector<std::string> names = look_words().names();
    names.emplace_back("right");
    return names;
  }();
  return keys;
}

SeriesLook read_look(lua_State* L, const Options& options, Series::Kind& kind) {
  return look_of(block_of(L, options, look_words()), kind, plain_number);
}

const std::string& look_type() {
  static const std::string type = [] {
    std::string text = table_type(look_words());
    text.pop_back();
    return text + ", right?: boolean}";
  }();
  return type;
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
  static const std::string options = "options?: " + table_type(script_figure_words());
  return {
      {"figure", guarded<make>, options, "pl.Figure",
       "a new figure. x and y are labels, or {label = ..., limits = {0, 1}, scale = \"log\"}; sizes in mm"},
  };
}

Entries figure_methods() {
  static const std::string options = "options?: " + table_type(script_panel_words());
  Entries entries = series_methods("pl.Figure");
  entries.push_back({"panel", guarded<panel>, options, "pl.Panel",
                     "adds a panel below; with an x of its own it does not share the figure's"});
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
