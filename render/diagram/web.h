// What the steps of the layout share: elements and nets, first without places, then with columns, rows and pixels.

#pragma once

#include <string>
#include <vector>

#include "render/diagram/arrangement.h"

namespace plantloop {

// A block, or one of the circles that a sum of many terms is split into. Elements are sorted by their keys.
struct Element {
  std::string key;  // path, and the number of the circle
  int block = 0;    // of the sheet
  SheetBlock::Shape shape = SheetBlock::Shape::box;
  bool has_state = false;
  std::vector<int> in, out;  // nets; -1: nothing is connected
  std::vector<std::string> in_text;

  bool is_feedback = false;  // all it gives goes back: drawn below, pointing to the left
  bool is_above = false;     // a source straight above the circle that it feeds, or
  bool is_below = false;     // straight below it
  bool is_beside() const { return is_above || is_below; }
  bool forced_forward = false, forced_feedback = false;
  int column = 0;
  int first_column = 0, last_column = 0;  // where else what leads back could stand

  double half_width = 0, half_height = 0;            // of the outline
  double left = 0, right = 0, above = 0, below = 0;  // of outline and captions, from the centre
  bool caption_above = false;
  std::vector<Side> in_side;
  std::vector<double> in_offset, out_offset;  // of ports on the left or right: y from the centre
};

struct Sink {
  int element = 0, port = 0;
  bool is_back = false;  // closes a loop
};

struct Net {
  int wire = -1;
  int element = 0, port = 0;  // where it comes from
  std::vector<Sink> sinks;
  bool is_shown = false;
};

struct Web {
  std::vector<Element> elements;
  std::vector<Net> nets;
  std::vector<int> main_path;  // elements
  int columns = 0;
  bool branches_first = false;  // begin the ordering with what branches off above the main path
  bool is_framed = false;       // inputs and outputs stand at the left and right edge
};

// loops.cpp: which connections close loops, and which elements lead back.
void find_feedback(Web& web);
// The lengths of the longest forward ways to each element; of elements that lead back, of what feeds them.
std::vector<int> forward_depths(const Web& web);

// split.cpp: circles with more inputs than have room become rows of circles; every input of a circle gets its side.
void split_circles(Web& web);

// columns.cpp: the main path, and a column for every element.
void give_columns(Web& web);

// A thing in a column: an element, a wire that passes, or the corner of a wire that enters a circle from above or
// below.
struct Item {
  enum class Kind { element, pass, corner };
  Kind kind = Kind::element;
  int element = -1;  // of a corner: the circle
  int net = -1;
  bool is_lane = false;     // belongs to what leads back
  bool from_above = false;  // of a corner
  int column = 0;
  int line = 0;  // of items on one height
  double y = 0;
  double above = 0, below = 0;  // room it takes
};

// An end of a net in a channel, the gap between column `c` and column `c + 1`.
struct End {
  int net = 0;
  int item = 0;
  double offset = 0;       // from the item's centre
  bool from_left = false;  // the item stands on the left of the channel
  bool is_source = false;  // the net comes from here
  int port = -1;           // of an element's input; -1 for others
  int flow = 0;            // ends of one flow are connected in this channel
};

struct Plan {
  std::vector<Item> items;
  std::vector<std::vector<int>> columns;   // items from top to bottom
  std::vector<std::vector<End>> channels;  // channel c + 1 lies between columns c and c + 1; 0 is left of all
  std::vector<double> column_x;            // centres
  std::vector<double> channel_left, channel_right;
  std::vector<double> label_room;        // of each channel: at its left end, for labels of wires
  std::vector<double> label_room_right;  // at its right end, of wires that begin to the left
};

// items.cpp: passes and corners for every connection, the ends in every channel, and the order in every column.
Plan make_plan(const Web& web);
void order_columns(const Web& web, Plan& plan);

// rows.cpp: a height for every item.
void give_heights(const Web& web, Plan& plan);

// tracks.cpp: a place for every vertical line; gives x of columns and channels, and the arrangement's nets.
void route(const Web& web, Plan& plan, Arrangement& arrangement);

}  // namespace plantloop
