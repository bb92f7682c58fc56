// What layout knows about a figure on the way to a scene; private to render/layout.

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/figure.h"
#include "render/geometry/curve.h"
#include "render/layout/ticks.h"
#include "render/text/label.h"
#include "render/theme.h"

namespace plantloop {

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
};

struct PlacedLabel {
  Label label;
  double x = 0, y = 0;
  Color color;
  bool veil = false;  // data pass below: dim them
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

struct PanelPlan {
  const Panel* panel = nullptr;
  const Axis* x_axis = nullptr;
  bool shows_x = true;  // tick labels and label of the x axis
  bool twin = false;
  Ruler x, y, right;
  std::optional<Color> left_color, right_color;  // when one series alone belongs to the axis of a twin panel
  std::vector<SeriesPlan> series;
  Box box;
  std::vector<Label> title, x_label, y_label, right_label;
  std::vector<Label> x_ticks, y_ticks, right_ticks;
  Label y_note, right_note, x_note;
  KeyPlan key;
  std::vector<double> end_label_y;
  std::vector<PlacedLabel> labels;  // of reference lines and bands
};

struct Plan {
  const Figure* figure = nullptr;
  const Theme* theme = nullptr;
  double unit = 1;  // pixels per sixth of a millimetre
  int width = 0, height = 0;
  std::vector<Label> title;
  double title_x = 0, title_y = 0;
  std::vector<PanelPlan> panels;

  LabelStyle text_style() const { return {theme->text_size * unit, false, false}; }
  LabelStyle tick_style() const { return {theme->text_size * unit, false, true}; }
  LabelStyle label_style() const { return {theme->label_size * unit, false, false}; }
};

// rulers.cpp: the ends and ticks of all axes, for the boxes the panels have now.
void set_rulers(Plan& plan);

// curves.cpp: the series of a panel in pixels.
void set_curves(const Plan& plan, PanelPlan& panel);
Spot to_pixels(const PanelPlan& panel, double x, double y, bool right);

// keys.cpp: end labels or a legend, and the labels of reference lines and bands.
void choose_end_labels(const Plan& plan, PanelPlan& panel);
void choose_legend(const Plan& plan, PanelPlan& panel);  // decides where; a legend above or beside needs room
void place_key(const Plan& plan, PanelPlan& panel);      // in the final box
void place_labels(const Plan& plan, PanelPlan& panel);
double end_label_width(const PanelPlan& panel);

// draw.cpp
Scene draw(const Plan& plan);

}  // namespace plantloop
