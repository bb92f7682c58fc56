// Where the blocks and wires of a sheet go: a layered layout as control engineers draw it.
//
// The forward path runs from left to right on one straight line; what leads back lies below and points to the left;
// sums are circles, fed from the left, from above and from below; every wire runs along the axes and has a track of its
// own. Coordinates are pixels, y down.

#pragma once

#include <string>
#include <vector>

#include "render/diagram/sheet.h"
#include "render/geometry/curve.h"

namespace plantloop {

enum class Side { left, right, top, bottom };

struct PlacedPort {
  Spot at;  // on the edge of the block
  Side side = Side::left;
  std::string text;  // of a circle: the sign; of a box with several ports: the port's name
};

// A block where it stands. A sum of many terms becomes a row of circles, which have the same `block`.
struct PlacedBlock {
  int block = 0;  // of the sheet
  SheetBlock::Shape shape = SheetBlock::Shape::box;
  Box box;                  // the outline
  bool is_flipped = false;  // points to the left
  bool is_feedback = false;
  std::vector<PlacedPort> inputs, outputs;
  bool caption_above = false;
};

struct PlacedArrow {
  Spot tip;
  Side side = Side::left;  // of the block that it meets
  int block = 0;           // of Arrangement::blocks
};

// A net as drawn: all of its lines, joined where `dots` are.
struct PlacedNet {
  int wire = -1;             // of the sheet; -1: between the circles of one sum
  std::vector<Curve> lines;  // each along the axes, ends at ports, dots or corners
  std::vector<Spot> dots;
  std::vector<PlacedArrow> arrows;
  Spot label;                    // the end of the label's base line at the block
  bool label_leftwards = false;  // it runs to the left from there
  std::vector<int> bends;        // of the way to each arrow
};

struct PlacedFrame;

struct Arrangement {
  double width = 0, height = 0;  // of everything, captions included; the origin is the top left corner
  std::vector<PlacedBlock> blocks;
  std::vector<PlacedNet> nets;
  std::vector<PlacedFrame> frames;  // of blocks with an inside
  std::vector<int> main_path;       // of `blocks`, from left to right
};

struct PlacedFrame {
  int block = 0;  // of Arrangement::blocks
  Spot origin;    // of the inside
  Arrangement inside;
};

Arrangement arrange(const Sheet& sheet, const std::vector<SheetHint>& hints = {});

// What is wrong with an arrangement, one line each; empty for a sound one. Looked for: blocks that overlap, lines that
// are not along the axes, that cross a block or lie on another net's, arrows that end beside their port, ports without
// wire, a forward path that turns back, ways with more than four bends.
std::vector<std::string> faults(const Sheet& sheet, const Arrangement& arrangement);

// Sizes that the layout and the drawing share, in pixels.
struct SheetStyle {
  double text = 16, caption = 14, note = 12.5;
  double box_width = 72, box_height = 52;  // at least
  double circle = 14;                      // radius
  double port_gap = 30;                    // between the ports of a block
  double padding = 14;                     // between a box and its formula
  double arrow = 11;                       // length of an arrow's head
  double stub = 22;                        // a wire's least straight end
  double track_gap = 18;                   // between neighbouring vertical lines
  double lane_gap = 26;                    // between neighbouring horizontal lines
  double row_gap = 30;                     // between neighbouring blocks of a column
  double frame_margin = 26;
  double top_name = 16;  // height of the name of what enters a box from above
  double stack = 5;      // from one outline of a repeated block to the next
};
inline constexpr SheetStyle sheet_style{};

}  // namespace plantloop
