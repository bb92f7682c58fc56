// Words to the figure's parts.

#include "app/figures/parts.h"

#include <algorithm>
#include <string_view>

#include "render/theme.h"

namespace plantloop {
namespace {

// The place of the chosen text among its choices: enumerations stand in the order of the words.
template <typename Enum>
void set_choice(const FigureBlock& says, std::string_view name, Enum& value) {
  const FigureEntry* entry = says.find(name);
  if (!entry || entry->text.empty()) return;
  const std::vector<std::string_view>& choices = entry->word->choices;
  const auto found = std::find(choices.begin(), choices.end(), entry->text);
  if (found != choices.end()) value = static_cast<Enum>(found - choices.begin());
}

void set_text(const FigureBlock& says, std::string_view name, std::string& value) {
  if (says.find(name)) value = says.text(name);
}

void set_limits(const FigureBlock& says, std::string_view name, Limits& limits, const NumberOf& number) {
  const FigureEntry* entry = says.find(name);
  if (!entry || entry->numbers.size() != 2) return;
  limits = {number(entry->numbers[0]), number(entry->numbers[1])};
}

std::optional<Color> color_of(const FigureBlock& says) {
  const std::string text = says.text("color");
  return text.empty() ? std::nullopt : parse_color(text);
}

struct Page {
  std::string_view name;
  double width, height;  // mm; no height: from the panels
};
constexpr Page pages[] = {{"one_column", 86, 0}, {"two_columns", 178, 0}, {"slide", 254, 143}, {"web", 200, 0}};

}  // namespace

std::optional<double> plain_number(const ExpressionPtr& expression) {
  if (!expression || expression->kind != Expression::Kind::number) return std::nullopt;
  return expression->number;
}

void set_axis(Axis& axis, const FigureBlock& says, const NumberOf& number) {
  set_text(says, "label", axis.label);
  set_limits(says, "limits", axis.limits, number);
  set_choice(says, "scale", axis.scale);
  set_text(says, "unit", axis.time_unit);
  axis.threshold = number(says.number("threshold")).value_or(axis.threshold);
}

void set_figure(Figure& figure, const FigureBlock& says, const NumberOf& number) {
  set_text(says, "title", figure.title);
  if (!says.text("theme").empty()) figure.theme = says.text("theme");
  for (const Page& page : pages)
    if (page.name == says.text("size")) figure.width = page.width, figure.height = page.height;
  figure.width = number(says.number("width")).value_or(figure.width);
  figure.height = number(says.number("height")).value_or(figure.height);
  figure.dpi = number(says.number("dpi")).value_or(figure.dpi);
  figure.columns = static_cast<int>(number(says.number("columns")).value_or(figure.columns));
  figure.share_y = says.flag("share_y");
  figure.selectable_text = says.flag("selectable_text");
  if (const FigureEntry* x = says.find("x")) {
    if (x->parts.empty())
      figure.x.label = x->text;
    else
      set_axis(figure.x, x->parts[0], number);
  }
}

void set_panel(Panel& panel, const FigureBlock& says, const Axis& shared, const NumberOf& number) {
  set_text(says, "title", panel.title);
  set_text(says, "label", panel.y.label);
  set_limits(says, "limits", panel.y.limits, number);
  set_choice(says, "scale", panel.y.scale);
  panel.y.threshold = number(says.number("threshold")).value_or(panel.y.threshold);
  set_text(says, "right_label", panel.right.label);
  set_limits(says, "right_limits", panel.right.limits, number);
  set_choice(says, "right_scale", panel.right.scale);
  if (says.find("x_label") || says.find("x_limits") || says.find("x_scale")) {
    if (!panel.x) panel.x = shared;
    set_text(says, "x_label", panel.x->label);
    if (says.find("x_label")) panel.x->time_unit.clear();
    set_limits(says, "x_limits", panel.x->limits, number);
    set_choice(says, "x_scale", panel.x->scale);
  }
  set_choice(says, "legend", panel.legend);
  panel.equal = panel.equal || says.flag("equal");
  panel.bare = panel.bare || says.flag("bare");
  panel.height = number(says.number("height")).value_or(panel.height);
  for (const FigureBlock& line : says.parts("lines")) panel.lines.push_back(line_of(line, number));
  for (const FigureBlock& band : says.parts("bands")) panel.bands.push_back(band_of(band, number));
  for (const FigureBlock& remark : says.parts("remarks")) panel.callouts.push_back(remark_of(remark, number));
  const FigureEntry* place = says.find("place");
  if (place && place->numbers.size() == 4) {
    const auto part = [&](std::size_t i) { return number(place->numbers[i]).value_or(0); };
    panel.place = Panel::Place{part(0), part(1), part(2), part(3)};
  }
}

SeriesLook look_of(const FigureBlock& says, Series::Kind& kind, const NumberOf& number) {
  SeriesLook look;
  look.label = says.text("label");
  const std::string style = says.text("style");
  if (style == "dashed") look.style = LineStyle::dashed;
  if (style == "dotted") look.style = LineStyle::dotted;
  if (style == "dashdot") look.style = LineStyle::dashdot;
  if (style == "none" || style == "points") look.style = LineStyle::none;
  if (style == "points" || style == "line_points") look.marker = Marker::dot;
  if (style == "steps") kind = Series::Kind::stairs;
  set_choice(says, "marker", look.marker);
  look.color = color_of(says);
  look.width = number(says.number("width")).value_or(0);
  look.opacity = number(says.number("opacity")).value_or(1);
  look.size = number(says.number("size")).value_or(0);
  return look;
}

ReferenceLine line_of(const FigureBlock& says, const NumberOf& number) {
  const bool vertical = says.find("x") != nullptr;
  ReferenceLine line{.axis = vertical ? ReferenceLine::x : ReferenceLine::y,
                     .at = number(says.number(vertical ? "x" : "y")).value_or(0),
                     .label = says.text("label"),
                     .color = color_of(says)};
  set_choice(says, "style", line.style);
  return line;
}

ReferenceBand band_of(const FigureBlock& says, const NumberOf& number) {
  return {.lower = number(says.number("lower")),
          .upper = number(says.number("upper")),
          .from = number(says.number("from")),
          .until = number(says.number("until")),
          .label = says.text("label"),
          .color = color_of(says)};
}

Callout remark_of(const FigureBlock& says, const NumberOf& number) {
  Callout remark{.x = number(says.number("x")).value_or(0),
                 .y = number(says.number("y")).value_or(0),
                 .label = says.text("label")};
  set_choice(says, "marker", remark.marker);
  remark.color = color_of(says);
  remark.right = says.flag("right");
  return remark;
}

}  // namespace plantloop
