// What a figure shows and how it is meant: plain values, no pixels. `layout` (render/layout.h) turns one into a scene.
//
//   Figure figure{.title = "Step response"};
//   figure.x.label = "time [s]";
//   Panel& panel = figure.add_panel({.y = {.label = "position [m]"}});
//   panel.line(time, position, {.label = "position"});
//   panel.lines.push_back({.axis = ReferenceLine::y, .at = 1.31, .label = "limit"});
//   write(to_png(layout(figure)));
//
// Labels are UTF-8. `x_1`, `x_{max}`, `s^{-1}` and Unicode sub- and superscripts are set as such; an underscore behind
// a name of more than two letters (`tire_force`) is an ordinary character; `\_` always is. `\theta` and the other Greek
// letters, `\frac{a}{b}`, `\sqrt{x}`, `\hat{y} \bar \dot \ddot \tilde`, `\cdot \times \pm \le \ge \ne \approx \infty
// \to \partial \nabla \int \sum \degree` as in TeX; a space behind them stays. Units stand last, in brackets.

#pragma once

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/color.h"
#include "render/space.h"

namespace plantloop {

enum class LineStyle { solid, dashed, dotted, dashdot, none };
enum class Marker { none, dot, ring, square, diamond, triangle, cross, plus, dash, tick };  // dash lies, tick stands
// symlog: as log on either side of zero, and straight between minus and plus the axis' threshold.
enum class Scale { linear, log, symlog };

// Where a series takes its colour from when it is given none: from the palette, in order; or from what the theme has
// for grids, reference lines and text. What has the ink of a grid or of a reference is drawn below the data, serves the
// data's limits only, and is never explained.
enum class Ink { palette, grid, reference, text };

// Ends that are not given are found from the data. On a logarithmic axis an end must be positive, else it is ignored.
struct Limits {
  std::optional<double> lower, upper;
};

struct AxisTick {
  double at = 0;
  std::string label;
};

struct Axis {
  std::string label;
  Limits limits;
  Scale scale = Scale::linear;
  double threshold = 0;         // of Scale::symlog; 0: a power of ten found from the data
  std::vector<AxisTick> ticks;  // instead of numbers: the names of bars; ascending
  // Of an x axis whose values are seconds: the unit they are shown in, ms s min h d, or auto by the axis' length. It
  // takes the place of the unit in the label. Empty: values are shown as they are.
  std::string time_unit;
  // An x axis that a plot type brought for what it shows: frequency, real part, lag. Of the figure's only panel it
  // takes what the user says of the figure's x.
  bool own = false;
  bool tight = false;  // ends where the data end, as an axis of time does; else at round numbers
};

// How a series is to look. What is left out follows the theme: the colour from the palette, in order.
struct SeriesLook {
  std::string label;  // empty: neither end label nor legend entry
  LineStyle style = LineStyle::solid;
  Marker marker = Marker::none;
  std::optional<Color> color;
  double width = 0;                     // in points; 0: the theme's
  std::optional<std::size_t> color_of;  // the colour of that series of the panel, counted from 0, right ones last
  bool same_color = false;              // as the series before it on its axis
  Ink ink = Ink::palette;
  double opacity = 1;  // of lines, markers and areas
  double size = 0;     // of markers and arrows, in points; 0: the theme's
};

// A polygon in the data's coordinates, filled with its series' colour or, where it has a value, with the colour that
// the panel's colour scale gives to it.
struct Area {
  std::vector<double> x, y;
  std::optional<double> value;
};

struct Series {
  enum class Kind {
    line,    // straight from sample to sample
    stairs,  // each value is held until the next sample (a discrete signal)
    band,    // the area between `lower` and `y`
    areas,   // polygons
    arrows,  // short arrows with their middles at x, y, pointing along (toward_x, toward_y)
  };
  Kind kind = Kind::line;
  std::vector<double> x, y;   // of equal length; a NaN breaks the line; equal x in succession: a jump, drawn vertically
  std::vector<double> lower;  // bands only
  SeriesLook look;
  std::vector<Area> areas;
  bool crisp = false;                      // the areas' edges lie on whole pixels: cells without seams
  std::vector<double> toward_x, toward_y;  // arrows only, in the data's units; their length does not matter
};

// One series each. The columns must have equal length, else std::invalid_argument.
Series line_series(std::vector<double> x, std::vector<double> y, SeriesLook look = {});
Series stairs_series(std::vector<double> x, std::vector<double> y, SeriesLook look = {});
// Samples without a line; dots unless look.marker says else.
Series marker_series(std::vector<double> x, std::vector<double> y, SeriesLook look = {});
Series band_series(std::vector<double> x, std::vector<double> lower, std::vector<double> upper, SeriesLook look = {});

// A thin line across the panel at a value of y (horizontal) or x (vertical).
struct ReferenceLine {
  enum Direction { y, x };
  Direction axis = y;
  double at = 0;
  std::string label;
  LineStyle style = LineStyle::dashed;
  std::optional<Color> color;
};

// A remark at a point: a marker, and words beside it where nothing else is, with a thin line to them when they had to
// go farther. A quiet one is small, muted, has no marker, and is left out where there is no room.
struct Callout {
  double x = 0, y = 0;
  std::string label;
  Marker marker = Marker::dot;
  std::optional<std::size_t> color_of;  // of that series; else the text's
  std::optional<Color> color;
  bool right = false;
  bool quiet = false;
};

// What the colours of areas and surfaces mean: shown as a bar beside the panel.
struct ColorScale {
  double lower = 0, upper = 1;
  std::string label;
  std::string map = "viridis";  // a name from color_maps()
  bool bar = true;
};

// A tinted area behind the data; sides that are not given reach to the end of the panel.
struct ReferenceBand {
  std::optional<double> lower, upper;  // in y
  std::optional<double> from, until;   // in x
  std::string label;
  std::optional<Color> color;
};

// Where a panel says which curve is which: automatic is at the curves' ends, else where no data is.
enum class Legend { automatic, none, top_left, top_right, bottom_left, bottom_right, above, beside };

struct Panel {
  std::string title;      // a small title above the panel; the figure's own stands above all
  std::optional<Axis> x;  // a horizontal axis of its own (a phase portrait); else the panel shares the figure's
  Axis y;                 // left
  Axis right;             // of the series in `right_series`, when there are any
  std::vector<Series> series, right_series;
  std::vector<ReferenceLine> lines;  // in coordinates of the left axis
  std::vector<ReferenceBand> bands;
  std::vector<Callout> callouts;
  std::optional<ColorScale> colors;
  Legend legend = Legend::automatic;
  bool equal = false;  // one unit is as long in x as in y
  bool bare = false;   // without axes, numbers and grid
  double height = 1;   // relative to the figure's other panels
  // Small panels inside this one. Their places: left, bottom, width and height as parts of this panel; by default where
  // the least data are. The part of this panel that they show, when their x has limits, is framed.
  std::vector<Panel> insets;
  struct Place {
    double left = 0, bottom = 0, width = 0, height = 0;
  };
  std::optional<Place> place;  // of an inset
  // What belongs to this panel and stands under it, whatever the figure's columns are: the phase under the gain. They
  // lie over its x axis, but for those with an x of their own; what is below them is not drawn.
  std::vector<Panel> below;
  std::optional<Space> space;  // three axes in perspective instead of two; then only title and colours count

  // Add a series to `series` and return it.
  Series& line(std::vector<double> x, std::vector<double> y, SeriesLook look = {});
  Series& stairs(std::vector<double> x, std::vector<double> y, SeriesLook look = {});
  Series& markers(std::vector<double> x, std::vector<double> y, SeriesLook look = {});
  Series& band(std::vector<double> x, std::vector<double> lower, std::vector<double> upper, SeriesLook look = {});
};

struct Figure {
  std::string title;
  std::string theme = "light";  // a name from theme_names()
  double width = 200;           // mm
  double height = 0;            // mm; 0: from the number and kind of the panels, 3:2 for one
  double dpi = 152.4;           // 6 pixels per mm: 1200 pixels at the default width
  // Shared by all panels without an x of their own. When it has neither label nor limits, only panels share it whose
  // data overlap and span a tenth of it at least.
  Axis x;
  bool selectable_text = false;  // of an SVG: a text that can be selected and found lies over the outlines
  int columns = 1;               // panels stand side by side in as many columns, row after row
  bool share_y = false;          // all panels have the left axis of the one that needs most
  std::vector<Panel> panels;

  Panel& add_panel(Panel panel = {});
};

}  // namespace plantloop
