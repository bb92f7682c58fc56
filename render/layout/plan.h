// What layout knows about a figure on the way to a scene; private to render/layout.

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/figure.h"
#include "render/geometry/curve.h"
#include "render/layout/occupancy.h"
#include "render/layout/ticks.h"
#include "render/text/label.h"
#include "render/theme.h"

namespace plantloop {

// A filled polygon.
struct Patch {
  Curve ring;
  Color color;
};

// A series with its place in the palette.
struct SeriesPlan {
  const Series* series = nullptr;
  bool right = false;
  Color color, text_color;
  double width = 2;  // pixels
  LineStyle style = LineStyle::solid;
  std::vector<Curve> lines;  // in pixels, decimated and clipped
  std::vector<Curve> areas;
  std::vector<Spot> marks;
  std::vector<Patch> shapes;
  double mark_radius = 3.6;
  // Grids and references: below the data, not explained, of no weight for limits.
  bool is_guide() const { return series->look.ink == Ink::grid || series->look.ink == Ink::reference; }
};

struct PlacedLabel {
  Label label;
  double x = 0, y = 0;
  Color color;
  bool veil = false;  // data pass below: dim them
  std::optional<std::pair<Spot, Spot>> leader;
  Box box() const { return {x + label.left, y + label.top, x + label.right, y + label.bottom}; }
};

// A callout's marker.
struct PlacedMark {
  Spot at;
  Marker marker = Marker::dot;
  Color color;
};

enum class KeyKind { none, end_labels, inside, above, beside };

// How the reader learns which line is which.
struct KeyPlan {
  KeyKind kind = KeyKind::none;
  std::vector<std::size_t> entries;  // indices of series
  std::vector<Label> labels;
  double row = 0, column = 0;  // size of an entry
  int columns = 1;
  std::size_t hidden = 0;  // entries for which there is no room
  Box box;
};

// The bar beside a panel that explains its colours.
struct ColorBar {
  const ColorScale* scale = nullptr;
  Ruler ruler;
  std::vector<Label> ticks, label;
  Label note;
};

inline constexpr std::size_t shared_axis = static_cast<std::size_t>(-1);

struct PanelPlan {
  const Panel* panel = nullptr;
  const Axis* x_axis = nullptr;
  bool shows_x = true;  // tick labels and label of the x axis
  bool shows_y = true;
  bool x_turned = false;  // its names stand upright, because beside each other they find no room
  int row = 0, column = 0;
  bool under = false;               // in the place of the panel before it, below it
  std::size_t owner = shared_axis;  // the panel over whose x axis it lies; or the figure's
  bool twin = false;
  bool is_inset = false;
  Ruler x, y, right;
  std::optional<Color> left_color, right_color;  // when one series alone belongs to the axis of a twin panel
  std::vector<SeriesPlan> series;
  Box box;
  std::vector<Label> title, x_label, y_label, right_label;
  std::vector<Label> x_ticks, y_ticks, right_ticks;
  Label y_note, right_note, x_note;
  KeyPlan key;
  std::vector<double> end_label_y;
  std::vector<PlacedLabel> labels;  // of reference lines, bands and callouts
  std::vector<PlacedMark> callouts;
  std::optional<ColorBar> bar;
  std::vector<PanelPlan> insets;
  std::optional<Box> inset_frame;  // of an inset: what it shows, in its parent's pixels
};

struct Plan {
  const Figure* figure = nullptr;
  const Theme* theme = nullptr;
  double unit = 1;  // pixels per sixth of a millimetre
  int width = 0, height = 0;
  int rows = 1, columns = 1;
  std::vector<Label> title;
  double title_x = 0, title_y = 0;
  std::vector<PanelPlan> panels;

  LabelStyle text_style() const { return {theme->text_size * unit, false, false}; }
  LabelStyle tick_style() const { return {theme->text_size * unit, false, true}; }
  LabelStyle label_style() const { return {theme->label_size * unit, false, false}; }
  LabelStyle remark_style() const { return {0.93 * theme->text_size * unit, false, false}; }
};

// seconds.cpp: the figure with its axes of time in the units asked for; nothing when there are none.
std::optional<Figure> in_units(const Figure& figure);

// panels.cpp: the plan of one panel, its series with their colours.
PanelPlan plan_panel(const Plan& plan, const Panel& panel);

// rulers.cpp: which panels leave a shared x axis because their data lie elsewhere; the ends and ticks of all axes, for
// the boxes the panels have now.
void part_axes(Plan& plan);
void set_rulers(Plan& plan);
void set_inset_rulers(const Plan& plan, PanelPlan& inset);

// curves.cpp: the series of a panel in pixels.
double arrow_length(const Plan& plan, const SeriesPlan& series);
void set_curves(const Plan& plan, PanelPlan& panel);
Spot to_pixels(const PanelPlan& panel, double x, double y, bool right);

// keys.cpp: end labels or a legend, and the labels of reference lines and bands.
void choose_end_labels(const Plan& plan, PanelPlan& panel);
void choose_legend(const Plan& plan, PanelPlan& panel);  // decides where; a legend above or beside needs room
void place_key(const Plan& plan, PanelPlan& panel);      // in the final box
double end_label_width(const PanelPlan& panel);

// remarks.cpp: the labels of reference lines, bands and callouts.
void place_labels(const Plan& plan, PanelPlan& panel);

// insets.cpp: places the insets of a panel whose box is final.
void place_insets(const Plan& plan, PanelPlan& panel);
// All that an inset covers: its box with the numbers beside it.
Box whole_inset(const Plan& plan, const PanelPlan& inset);

// What there is to see in a panel, for what is to be placed where nothing is.
Occupancy map_of(const PanelPlan& panel);
// The free place for a box of this size, or the best there is; `cost` tells which.
Box emptiest(const PanelPlan& panel, const Occupancy& map, double width, double height, double inset, double& cost);

// bar.cpp: the colour bar.
void set_bar(const Plan& plan, PanelPlan& panel);
double bar_width(const Plan& plan, const PanelPlan& panel);  // the room it needs at the panel's right
void draw_bar(Group& group, const Plan& plan, const PanelPlan& panel, double left, const std::string& role);

// space.cpp: a panel in three dimensions.
void draw_space(Group& group, const Plan& plan, const PanelPlan& panel, const std::string& role);

// marks.cpp: a filled box, and the shape of a marker of radius r; what is open (ring, cross, plus) is drawn by lines.
Fill box_fill(const Box& box, Color color);
void add_marker(Fill& filled, Stroke& drawn, Marker marker, Spot at, double r);

// draw.cpp
Scene draw(const Plan& plan);

}  // namespace plantloop
