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
// a name of more than two letters (`tire_force`) is an ordinary character; `\_` always is. Units stand last, in
// brackets.

#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/color.h"

namespace plantloop {

enum class LineStyle { solid, dashed, dotted, none };
enum class Marker { none, dot, ring, square, diamond, triangle, cross, plus };
enum class Scale { linear, log };

// Ends that are not given are found from the data. On a logarithmic axis an end must be positive, else it is ignored.
struct Limits {
  std::optional<double> lower, upper;
};

struct Axis {
  std::string label;
  Limits limits;
  Scale scale = Scale::linear;
};

// How a series is to look. What is left out follows the theme: the colour from the palette, in order.
struct SeriesLook {
  std::string label;  // empty: neither end label nor legend entry
  LineStyle style = LineStyle::solid;
  Marker marker = Marker::none;
  std::optional<Color> color;
  double width = 0;                     // in points; 0: the theme's
  std::optional<std::size_t> color_of;  // the colour of that series of the panel, counted from 0, right ones last
};

struct Series {
  enum class Kind {
    line,    // straight from sample to sample
    stairs,  // each value is held until the next sample (a discrete signal)
    band,    // the area between `lower` and `y`
  };
  Kind kind = Kind::line;
  std::vector<double> x, y;   // of equal length; a NaN breaks the line; equal x in succession: a jump, drawn vertically
  std::vector<double> lower;  // bands only
  SeriesLook look;
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

// A tinted area behind the data; sides that are not given reach to the end of the panel.
struct ReferenceBand {
  std::optional<double> lower, upper;  // in y
  std::optional<double> from, until;   // in x
  std::string label;
  std::optional<Color> color;
};

struct Panel {
  std::string title;      // a small title above the panel; the figure's own stands above all
  std::optional<Axis> x;  // a horizontal axis of its own (a phase portrait); else the panel shares the figure's
  Axis y;                 // left
  Axis right;             // of the series in `right_series`, when there are any
  std::vector<Series> series, right_series;
  std::vector<ReferenceLine> lines;  // in coordinates of the left axis
  std::vector<ReferenceBand> bands;
  bool equal = false;  // one unit is as long in x as in y
  double height = 1;   // relative to the figure's other panels

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
  Axis x;                       // shared by all panels without an x of their own
  std::vector<Panel> panels;

  Panel& add_panel(Panel panel = {});
};

}  // namespace plantloop
