// The tables of figures' words.

#include "engine/diagram/figure_words.h"

#include <initializer_list>

#include "engine/base/colors.h"

namespace plantloop {
namespace {

using Kind = FigureWord::Kind;

std::vector<std::string_view> color_names() {
  std::vector<std::string_view> names;
  for (const NamedColor& color : named_colors()) names.push_back(color.name);
  return names;
}

FigureWords joined(std::string_view what, std::initializer_list<std::vector<FigureWord>> lists) {
  FigureWords all{what, {}};
  for (const std::vector<FigureWord>& list : lists) all.words.insert(all.words.end(), list.begin(), list.end());
  return all;
}

const std::vector<std::string_view> scales{"linear", "log", "symlog"};
const std::vector<std::string_view> markers{"none",     "dot",   "ring", "square", "diamond",
                                            "triangle", "cross", "plus", "dash",   "tick"};
const std::vector<std::string_view> dashes{"solid", "dashed", "dotted", "dashdot"};

FigureWord color_word(std::string_view doc) { return {"color", Kind::color, doc, color_names()}; }

}  // namespace

const FigureWord* FigureWords::find(std::string_view name) const {
  for (const FigureWord& word : words)
    if (word.name == name) return &word;
  return nullptr;
}

std::vector<std::string> FigureWords::names() const {
  std::vector<std::string> all;
  for (const FigureWord& word : words) all.emplace_back(word.name);
  return all;
}

const FigureWords& axis_words() {
  static const FigureWords words{
      "an axis",
      {
          {"label", Kind::text, "what it shows, its unit last in brackets"},
          {"limits", Kind::limits, "its ends; `auto` finds one from the data"},
          {"scale", Kind::choice, "symlog: as log on either side of zero, straight between", scales},
          {.name = "threshold",
           .kind = Kind::number,
           .doc = "where symlog begins to be straight; by default a power of ten found from the data",
           .least = 0},
          {"unit",
           Kind::choice,
           "of an axis in seconds: the unit in which it is written; auto chooses by its length",
           {"auto", "ms", "s", "min", "h", "d"}},
      }};
  return words;
}

const FigureWords& line_words() {
  static const FigureWords words{"a line",
                                 {
                                     {"x", Kind::number, "where it stands upright"},
                                     {"y", Kind::number, "where it lies"},
                                     {"label", Kind::text, "words at the line"},
                                     {"style", Kind::choice, "its dashes", dashes},
                                     color_word("its colour"),
                                 }};
  return words;
}

const FigureWords& band_words() {
  static const FigureWords words{"a band",
                                 {
                                     {"lower", Kind::number, "its lower edge"},
                                     {"upper", Kind::number, "its upper edge"},
                                     {"from", Kind::number, "its left edge"},
                                     {"until", Kind::number, "its right edge"},
                                     {"label", Kind::text, "words in the band"},
                                     color_word("its tint"),
                                 }};
  return words;
}

const FigureWords& remark_words() {
  static const FigureWords words{"a remark",
                                 {
                                     {"x", Kind::number, "the point's place"},
                                     {"y", Kind::number, "the point's height"},
                                     {"label", Kind::text, "what is said about it"},
                                     {"marker", Kind::choice, "how the point is marked", markers},
                                     color_word("of marker and words"),
                                     {"right", Kind::flag, "y is of the right axis"},
                                 }};
  return words;
}

const FigureWords& look_words() {
  static const FigureWords words{
      "a curve",
      {
          {"label", Kind::text, "its name; a signal's own by default"},
          {"style",
           Kind::choice,
           "its dashes; points and line_points have markers, steps hold each value",
           {"solid", "dashed", "dotted", "dashdot", "none", "points", "line_points", "steps"}},
          {"marker", Kind::choice, "at each sample", markers},
          color_word("by default the palette's, in order"),
          {.name = "width", .kind = Kind::number, .doc = "of the line, in points", .least = 0},
          {.name = "opacity", .kind = Kind::number, .doc = "0 to 1", .least = 0, .most = 1},
          {.name = "size", .kind = Kind::number, .doc = "of markers and arrows, in points", .least = 0},
      }};
  return words;
}

const FigureWords& curve_words() {
  static const FigureWords words = joined("a curve", {{{"signal", Kind::signal, "what it shows"}}, look_words().words});
  return words;
}

const FigureWords& picture_words() {
  static const FigureWords words{
      "a figure",
      {
          {"title", Kind::text, "above all"},
          {.name = "x", .kind = Kind::axis, .doc = "the axis that panels share, or its label", .parts = &axis_words()},
          {"theme", Kind::choice, "its colours", {"light", "dark", "print"}},
          {"size",
           Kind::choice,
           "its size by name: one_column 86 mm, two_columns 178 mm, slide 254 mm by 143 mm, web 200 mm",
           {"one_column", "two_columns", "slide", "web"}},
          {.name = "width", .kind = Kind::number, .doc = "in mm, 200 by default", .least = 20},
          {.name = "height", .kind = Kind::number, .doc = "in mm, by default from the panels", .least = 0},
          {.name = "dpi", .kind = Kind::number, .doc = "of a PNG, 152.4 by default", .least = 10},
          {.name = "columns",
           .kind = Kind::number,
           .doc = "so many panels stand beside each other",
           .least = 1,
           .most = 20,
           .whole = true},
          {"share_y", Kind::flag, "all panels have one left axis"},
          {"selectable_text", Kind::flag,
           "of an SVG: its words can be selected and found; its letters are outlines anyway"},
      }};
  return words;
}

const FigureWords& frame_words() {
  static const FigureWords words{
      "a panel",
      {
          {"label", Kind::text, "of the left axis, its unit last in brackets"},
          {"limits", Kind::limits, "of the left axis; `auto` finds one from the data"},
          {"scale", Kind::choice, "of the left axis", scales},
          {.name = "threshold", .kind = Kind::number, .doc = "where symlog begins to be straight", .least = 0},
          {"right_label", Kind::text, "of the right axis"},
          {"right_limits", Kind::limits, "of the right axis"},
          {"right_scale", Kind::choice, "of the right axis", scales},
          {"x_label", Kind::text, "of an x axis of its own"},
          {"x_limits", Kind::limits, "of an x axis of its own"},
          {"x_scale", Kind::choice, "of an x axis of its own", scales},
          {"title", Kind::text, "above the panel"},
          {.name = "lines", .kind = Kind::list, .doc = "thin lines across", .parts = &line_words()},
          {.name = "bands", .kind = Kind::list, .doc = "tinted parts", .parts = &band_words()},
          {.name = "remarks", .kind = Kind::list, .doc = "marked points with words", .parts = &remark_words()},
          {"legend",
           Kind::choice,
           "where it says which curve is which; by default where no data is",
           {"auto", "none", "top_left", "top_right", "bottom_left", "bottom_right", "above", "beside"}},
          {"equal", Kind::flag, "one unit is as long in x as in y"},
          {"bare", Kind::flag, "without axes and grid"},
          {.name = "height", .kind = Kind::number, .doc = "relative to the other panels", .least = 0.05},
      }};
  return words;
}

const FigureWords& inset_frame_words() {
  static const FigureWords words = [] {
    FigureWords made{"an inset", {}};
    for (const FigureWord& word : frame_words().words)
      if (word.name != "title" && word.name != "height" && !word.name.starts_with("right_")) made.words.push_back(word);
    made.words.push_back({.name = "place",
                          .kind = Kind::numbers,
                          .doc = "left, bottom, width and height as parts of the panel; by default where least is",
                          .count = 4});
    return made;
  }();
  return words;
}

namespace {

// What a panel of a diagram shows.
std::vector<FigureWord> shown_words() {
  return {
      {.name = "y", .kind = Kind::signals, .doc = "the signals shown", .parts = &curve_words()},
      {.name = "x", .kind = Kind::signals, .doc = "over which one, by default time", .parts = &curve_words()},
      {"labels", Kind::texts, "one for each entry of y"},
  };
}

}  // namespace

const FigureWords& inset_words() {
  static const FigureWords words = joined("an inset", {shown_words(), inset_frame_words().words});
  return words;
}

const FigureWords& panel_words() {
  static const FigureWords words = joined(
      "a panel",
      {shown_words(),
       {{.name = "right", .kind = Kind::signals, .doc = "those of the right axis", .parts = &curve_words()}},
       frame_words().words,
       {{.name = "insets", .kind = Kind::list, .doc = "small panels inside this one", .parts = &inset_words()}}});
  return words;
}

const FigureWords& figure_words() {
  static const FigureWords words = joined(
      "a figure", {picture_words().words,
                   {{.name = "panels", .kind = Kind::list, .doc = "below each other", .parts = &panel_words()}}});
  return words;
}

}  // namespace plantloop
