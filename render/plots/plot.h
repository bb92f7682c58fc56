// What a plot type is: one file render/plots/<name>.cpp that declares what it is given and adds series, lines and
// callouts to a figure.
//
//   struct Stem : Plot {
//     Column x{this, "x", "where the stems stand"};
//     Column y{this, "y", "how far they reach"};
//     Real base{this, "base", 0, "where they begin"};
//     Stem() : Plot("samples as stems from a base line") {}
//     void draw(Canvas& canvas, const Given& given) const override { ... given[x] ... }
//     Figure example() const override { ... }
//   };
//   PLANTLOOP_PLOT(stem, Stem)
//
// From the declaration follow the method of Lua's figures and panels, `figure:stem(x, y, {base = 0})`, with its
// declaration for editors, the gallery, and the tests that hold for every type.

#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "render/figure.h"

namespace plantloop {

class Canvas;
class Given;
class Plot;

// Numbers in rows and columns, row by row.
struct GridValues {
  std::size_t rows = 0, columns = 0;
  std::vector<double> values;
  double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

using PlotValue =
    std::variant<std::monostate, std::vector<double>, GridValues, double, bool, std::string, std::vector<std::string>>;

enum class Need { needed, optional };

// One thing that a plot type is given.
struct PlotInput {
  enum class Kind { column, grid, number, flag, choice, text, texts };
  Kind kind = Kind::column;
  std::string_view name, doc;
  Need need = Need::needed;
  PlotValue init;                           // where nothing is given
  std::vector<std::string> choices{};       // of a choice; the first is the default
  std::vector<std::string_view> instead{};  // of what is optional only where one of these inputs is given
};

class Plot {
 public:
  // The kinds of inputs, declared as members of a plot type. Each knows its place among them.
  struct Part {
    Part(Plot* plot, PlotInput input);
    std::size_t index;
  };
  struct Column : Part {
    Column(Plot* plot, std::string_view name, std::string_view doc, Need need = Need::needed,
           std::vector<std::string_view> instead = {});
  };
  struct Grid : Part {
    Grid(Plot* plot, std::string_view name, std::string_view doc, Need need = Need::needed);
  };
  struct Real : Part {
    Real(Plot* plot, std::string_view name, double init, std::string_view doc);
  };
  struct Flag : Part {
    Flag(Plot* plot, std::string_view name, std::string_view doc, bool init = false);
  };
  struct Choice : Part {
    Choice(Plot* plot, std::string_view name, std::initializer_list<std::string_view> choices, std::string_view doc);
  };
  struct Text : Part {
    Text(Plot* plot, std::string_view name, std::string_view doc);
  };
  struct Texts : Part {
    Texts(Plot* plot, std::string_view name, std::string_view doc);
  };

  explicit Plot(std::string_view summary) : summary_(summary) {}
  Plot(const Plot&) = delete;
  Plot& operator=(const Plot&) = delete;
  virtual ~Plot() = default;

  // Adds to the canvas. Any numbers are accepted, none included; what cannot be drawn is left out. Throws RenderError
  // for what the user should know: columns of different length, a polynomial that is zero.
  virtual void draw(Canvas& canvas, const Given& given) const = 0;
  // The plot type at its best, for the gallery.
  virtual Figure example() const = 0;

  std::string_view name() const { return name_; }
  std::string_view summary() const { return summary_; }
  const std::vector<PlotInput>& inputs() const { return inputs_; }

  // Draws into the figure's panel with what is given, as scripts and examples do.
  void use(Figure& figure, std::size_t panel, std::initializer_list<std::pair<std::string_view, PlotValue>> values,
           SeriesLook look = {}) const;
  void use(Canvas& canvas, std::initializer_list<std::pair<std::string_view, PlotValue>> values,
           SeriesLook look = {}) const;

 private:
  template <typename T>
  friend struct NamedPlot;
  std::string_view name_, summary_;
  std::vector<PlotInput> inputs_;
};

// What one use of a plot type is given: each value of the kind declared, and how the series is to look.
class Given {
 public:
  explicit Given(const Plot& plot);
  // Throws RenderError when the value is of another kind, or none of the choices.
  void set(std::string_view input, PlotValue value);
  // Throws RenderError when something required is missing.
  void check() const;

  bool has(const Plot::Part& part) const { return !std::holds_alternative<std::monostate>(values_[part.index]); }
  const std::vector<double>& operator[](const Plot::Column& part) const;  // empty when optional and not given
  const GridValues& operator[](const Plot::Grid& part) const;
  double operator[](const Plot::Real& part) const { return std::get<double>(values_[part.index]); }
  bool operator[](const Plot::Flag& part) const { return std::get<bool>(values_[part.index]); }
  const std::string& operator[](const Plot::Choice& part) const { return std::get<std::string>(values_[part.index]); }
  const std::string& operator[](const Plot::Text& part) const { return std::get<std::string>(values_[part.index]); }
  const std::vector<std::string>& operator[](const Plot::Texts& part) const;

  SeriesLook look;
  bool right = false;  // on the panel's right axis

 private:
  const Plot* plot_;
  std::vector<PlotValue> values_;
};

// The figure that is drawn into, and where.
class Canvas {
 public:
  Canvas(Figure& figure, std::size_t panel) : figure_(figure), first_(panel) {}
  // Into an inset of that panel.
  Canvas(Figure& figure, std::size_t panel, std::size_t inset)
      : figure_(figure), first_(panel), inset_(static_cast<std::ptrdiff_t>(inset)) {}
  Figure& figure() { return figure_; }
  // The panel the plot was asked for, and those that stand under it, which are made when there are none yet. A
  // reference to one of these lasts until the next is made.
  Panel& panel(std::size_t below = 0);
  // The canvas of a panel under this one.
  Canvas under(std::size_t below) const;
  // The panel's own x axis, for what is not over the x that panels share. It neither takes from nor gives to the
  // figure's, unless the panel is its only one.
  Axis& own_x();
  // Adds a series to the panel, right or left; gives its index among all the panel's series.
  std::size_t add(Series series, const Given& given, std::size_t below = 0);
  // Says what an axis shows, unless the user has.
  static void name(Axis& axis, std::string_view label);

 private:
  Figure& figure_;
  std::size_t first_;
  std::ptrdiff_t inset_ = -1;
  std::size_t below_ = 0;
};

// All plot types, sorted by name: made from the names of the files in render/plots.
const std::vector<const Plot*>& plots();
const Plot* find_plot(std::string_view name);

// "x has 3 numbers and y has 2", as RenderError, when they differ.
void check_lengths(std::string_view a, const std::vector<double>& x, std::string_view b, const std::vector<double>& y);

template <typename T>
struct NamedPlot final : T {
  explicit NamedPlot(std::string_view name) { this->name_ = name; }
};

#define PLANTLOOP_PLOT(name, Type)            \
  const Plot& plantloop_plot_##name();        \
  const Plot& plantloop_plot_##name() {       \
    static const NamedPlot<Type> plot{#name}; \
    return plot;                              \
  }

}  // namespace plantloop
