// What all plot types share: declaring, checking what is given, and reaching panels.

#include <fmt/format.h>

#include <algorithm>

#include "render/error.h"
#include "render/plots/plot.h"

namespace plantloop {

Plot::Part::Part(Plot* plot, PlotInput input) : index(plot->inputs_.size()) {
  plot->inputs_.push_back(std::move(input));
}

const Plot* find_plot(std::string_view name) {
  for (const Plot* plot : plots())
    if (plot->name() == name) return plot;
  return nullptr;
}

Plot::Column::Column(Plot* plot, std::string_view name, std::string_view doc, Need need,
                     std::vector<std::string_view> instead)
    : Part(plot, {PlotInput::Kind::column, name, doc, need, {}, {}, std::move(instead)}) {}
Plot::Grid::Grid(Plot* plot, std::string_view name, std::string_view doc, Need need)
    : Part(plot, {PlotInput::Kind::grid, name, doc, need, {}}) {}
Plot::Real::Real(Plot* plot, std::string_view name, double init, std::string_view doc)
    : Part(plot, {PlotInput::Kind::number, name, doc, Need::optional, init}) {}
Plot::Flag::Flag(Plot* plot, std::string_view name, std::string_view doc, bool init)
    : Part(plot, {PlotInput::Kind::flag, name, doc, Need::optional, init}) {}
Plot::Choice::Choice(Plot* plot, std::string_view name, std::initializer_list<std::string_view> choices,
                     std::string_view doc)
    : Part(plot, {PlotInput::Kind::choice,
                  name,
                  doc,
                  Need::optional,
                  std::string(*choices.begin()),
                  {choices.begin(), choices.end()}}) {}
Plot::Text::Text(Plot* plot, std::string_view name, std::string_view doc)
    : Part(plot, {PlotInput::Kind::text, name, doc, Need::optional, std::string()}) {}
Plot::Texts::Texts(Plot* plot, std::string_view name, std::string_view doc)
    : Part(plot, {PlotInput::Kind::texts, name, doc, Need::optional, std::vector<std::string>()}) {}

namespace {

// "a, b or c"
std::string one_of(const std::vector<std::string>& choices) {
  std::string text = choices.front();
  for (std::size_t i = 1; i < choices.size(); ++i) text += (i + 1 < choices.size() ? ", " : " or ") + choices[i];
  return text;
}

}  // namespace

Given::Given(const Plot& plot) : plot_(&plot) {
  for (const PlotInput& input : plot.inputs()) values_.push_back(input.init);
}

void Given::set(std::string_view name, PlotValue value) {
  const std::vector<PlotInput>& inputs = plot_->inputs();
  const auto found = std::find_if(inputs.begin(), inputs.end(), [&](const PlotInput& i) { return i.name == name; });
  if (found == inputs.end()) throw RenderError(fmt::format("{} has no '{}'", plot_->name(), name));
  using Kind = PlotInput::Kind;
  const auto is = [&](auto sample) { return std::holds_alternative<decltype(sample)>(value); };
  const bool fits = found->kind == Kind::column   ? is(std::vector<double>())
                    : found->kind == Kind::grid   ? is(GridValues())
                    : found->kind == Kind::number ? is(double())
                    : found->kind == Kind::flag   ? is(bool())
                    : found->kind == Kind::texts  ? is(std::vector<std::string>())
                                                  : is(std::string());
  if (!fits) throw RenderError(fmt::format("'{}' of {} is of another kind", name, plot_->name()));
  if (found->kind == Kind::choice) {
    const std::string& chosen = std::get<std::string>(value);
    if (std::find(found->choices.begin(), found->choices.end(), chosen) == found->choices.end())
      throw RenderError(fmt::format("'{}' must be {}, it is '{}'", name, one_of(found->choices), chosen));
  }
  values_[static_cast<std::size_t>(found - inputs.begin())] = std::move(value);
}

void Given::check() const {
  for (std::size_t i = 0; i < values_.size(); ++i)
    if (plot_->inputs()[i].need == Need::needed && std::holds_alternative<std::monostate>(values_[i]))
      throw RenderError(fmt::format("'{}' is missing: {}", plot_->inputs()[i].name, plot_->inputs()[i].doc));
}

const std::vector<double>& Given::operator[](const Plot::Column& part) const {
  static const std::vector<double> none;
  const auto* column = std::get_if<std::vector<double>>(&values_[part.index]);
  return column ? *column : none;
}

const GridValues& Given::operator[](const Plot::Grid& part) const {
  static const GridValues none;
  const auto* grid = std::get_if<GridValues>(&values_[part.index]);
  return grid ? *grid : none;
}

const std::vector<std::string>& Given::operator[](const Plot::Texts& part) const {
  return std::get<std::vector<std::string>>(values_[part.index]);
}

Panel& Canvas::panel(std::size_t below) {
  while (figure_.panels.size() <= first_) figure_.add_panel();
  Panel& outer = figure_.panels[first_];
  Panel& own = inset_ >= 0 ? outer.insets[static_cast<std::size_t>(inset_)] : outer;
  const std::size_t at = below_ + below;
  if (at == 0) return own;
  while (own.below.size() < at) own.below.emplace_back();
  return own.below[at - 1];
}

Canvas Canvas::under(std::size_t below) const {
  Canvas result = *this;
  result.below_ += below;
  return result;
}

Axis& Canvas::own_x() {
  Panel& target = panel();
  if (!target.x) target.x = Axis{.own = true};
  target.x->tight = false;
  return *target.x;
}

std::size_t Canvas::add(Series series, const Given& given, std::size_t below) {
  Panel& target = panel(below);
  if (given.right) {
    target.right_series.push_back(std::move(series));
    return target.series.size() + target.right_series.size() - 1;
  }
  target.series.push_back(std::move(series));
  return target.series.size() - 1;
}

void Canvas::name(Axis& axis, std::string_view label) {
  if (axis.label.empty()) axis.label = label;
}

void Plot::use(Figure& figure, std::size_t panel, std::initializer_list<std::pair<std::string_view, PlotValue>> values,
               SeriesLook look) const {
  Canvas canvas(figure, panel);
  use(canvas, values, std::move(look));
}

void Plot::use(Canvas& canvas, std::initializer_list<std::pair<std::string_view, PlotValue>> values,
               SeriesLook look) const {
  Given given(*this);
  for (const auto& [input, value] : values) given.set(input, value);
  given.look = std::move(look);
  given.check();
  canvas.panel();
  draw(canvas, given);
}

void check_lengths(std::string_view a, const std::vector<double>& x, std::string_view b, const std::vector<double>& y) {
  if (x.size() != y.size()) throw RenderError(fmt::format("{} has {} numbers and {} has {}", a, x.size(), b, y.size()));
}

}  // namespace plantloop
