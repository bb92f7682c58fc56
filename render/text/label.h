// Sets a label: splits it into runs of one font, size and height, and measures it.

#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "render/scene/scene.h"

namespace plantloop {

struct LabelStyle {
  double size = 15;      // pixels to the em
  bool strong = false;   // semibold
  bool tabular = false;  // digits of equal width
};

// A label that is set but not yet placed. Measures in pixels from the origin on the base line; y down.
struct Label {
  std::string source;  // what is read aloud: the text with its sub- and superscripts in Unicode where they exist
  std::vector<GlyphRun> runs;
  double width = 0;            // advance
  double left = 0, right = 0;  // of the ink
  double top = 0, bottom = 0;  // of the ink: top is negative for letters above the base line
  double size = 0;             // pixels to the em
  bool empty() const { return runs.empty(); }
};

// Syntax as in render/figure.h. Never fails: bytes that are no UTF-8 become U+FFFD, unknown characters the box glyph.
Label set_label(std::string_view text, const LabelStyle& style);

// The longest beginning that fits, with an ellipsis; the text itself when it fits. A unit in brackets at the end stays.
Label set_label_within(std::string_view text, const LabelStyle& style, double width);

// The same with the ellipsis in the middle: names that differ at their ends stay different.
Label set_label_shortened(std::string_view text, const LabelStyle& style, double width);

// Of each text what tells it from the others, an ellipsis for what all of them begin and end with; whole words only.
// The texts themselves when they have nothing in common.
std::vector<std::string> distinct_parts(const std::vector<std::string>& texts);

// Breaks at spaces into at most `lines` lines of the given width; the last line is cut with an ellipsis if need be.
std::vector<Label> set_lines(std::string_view text, const LabelStyle& style, double width, int lines);

// Puts the label with its origin there.
TextRun place(const Label& label, double x, double y, int turns, Color color, Color background);

// Height of capital letters and of small ones, as a part of the em.
constexpr double cap_height = 0.727;
constexpr double x_height = 0.546;

}  // namespace plantloop
