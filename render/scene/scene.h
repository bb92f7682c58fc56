// A scene: what is to be seen, as a tree of few kinds of primitives with whole-number coordinates.
//
// Coordinates are in pixels at the figure's resolution, 24.8 fixed point (256 to the pixel), x to the right and y down.
// Everything that makes a figure (ticks, text, decimation, dashes' phase) is decided above the scene; a backend only
// draws it. The order in the tree is the order of drawing.

#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "render/color.h"

namespace plantloop {

using Fixed = std::int32_t;  // 24.8

struct Point {
  Fixed x = 0, y = 0;
  friend bool operator==(const Point&, const Point&) = default;
};

struct Rect {
  Fixed left = 0, top = 0, right = 0, bottom = 0;
  friend bool operator==(const Rect&, const Rect&) = default;
};

using Polyline = std::vector<Point>;

// A filled area bounded by closed rings, non-zero winding.
struct Fill {
  std::vector<Polyline> rings;
  Color color;
};

// Lines with round joins.
struct Stroke {
  enum class Cap { butt, round };
  std::vector<Polyline> lines;
  Fixed width = 256;
  std::vector<Fixed> dashes;  // lengths of dash, gap, ...; empty: solid
  Cap cap = Cap::butt;
  Color color;
};

// Glyphs of one font and size; positions in font units from the text's origin before scaling to `size`.
struct GlyphRun {
  struct Glyph {
    std::uint32_t id = 0;
    std::int32_t x = 0, y = 0;  // in units of the em square, y up
    friend bool operator==(const Glyph&, const Glyph&) = default;
  };
  int font = 0;    // index into Scene::fonts
  Fixed size = 0;  // pixels to the em
  Point at;        // of the run, from the text's origin, before turning
  std::vector<Glyph> glyphs;
  friend bool operator==(const GlyphRun&, const GlyphRun&) = default;
};

struct TextRun {
  std::string source;  // the characters as a reader would say them
  Point origin;        // on the base line
  int turns = 0;       // quarter turns anticlockwise
  Rect box;            // of the ink, in the scene
  std::vector<GlyphRun> runs;
  Color color;
  Color background;  // what lies behind; for the contrast check
};

struct SceneNode;

// Things that belong together. The role says what they are: "panel/0/y/ticks", "panel/0/series/2".
struct Group {
  std::string role;
  std::string name;  // the label of a series; else empty
  std::optional<Rect> clip;
  std::vector<SceneNode> children;

  Group& group(std::string child_role, std::string child_name = {});
  void add(SceneNode node);
};

struct SceneNode {
  std::variant<Fill, Stroke, TextRun, Group> item;
};

struct SceneFont {
  std::string name, sha256;
  friend bool operator==(const SceneFont&, const SceneFont&) = default;
};

struct Scene {
  std::string title;
  int width = 0, height = 0;  // pixels
  double dpi = 0;
  Color background{255, 255, 255};
  bool selectable_text = false;  // in formats that draw text as outlines: readers can select and find it all the same
  std::vector<SceneFont> fonts;
  Group root{"figure", {}, {}, {}};
};

}  // namespace plantloop
