// A block diagram as it is to be drawn: blocks with faces, and wires between their ports; plain values, no places.
//
//   Sheet sheet;
//   ... blocks and wires ...
//   const Arrangement arrangement = arrange(sheet);         // where everything goes (render/diagram/arrangement.h)
//   const Scene scene = draw(sheet, arrangement, "light");  // as a scene
//
// The picture depends on what is connected to what and on the names, never on the order of blocks and wires.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "render/diagram/formula.h"
#include "render/geometry/curve.h"

namespace plantloop {

struct Sheet;

struct SheetBlock {
  enum class Shape {
    box,
    gain,    // a triangle that points along the signal
    circle,  // adds or multiplies; the texts of the inputs are the signs + − × ÷
    bar,     // joins signals to a vector
    value,   // a number, or a name of one, that feeds something
    input,   // where a signal enters the sheet: its name
    output,  // where a signal leaves the sheet
  };
  std::string path;  // unique on the sheet; decides all ties
  Shape shape = Shape::box;
  Formula formula;            // on the face
  std::vector<Curve> curves;  // on the face instead, in a unit square with y up: a characteristic or a waveform
  std::vector<Curve> axes;    // thin lines behind the curves
  std::string caption;        // below the block
  std::string note;           // below the caption, smaller: a rate, a value
  std::vector<std::string> inputs, outputs;  // one text for each port; shown where there are several
  bool has_state = false;                    // of a plant rather than of a sensor
  bool is_subsystem = false;
  int copies = 1;      // more than one: a repeated block, drawn as a stack
  int top_input = -1;  // of a box: the input that comes in at the top, such as the condition under which it runs
  // The inside, drawn in a frame; its blocks of shapes input and output are the ports, in order.
  std::shared_ptr<const Sheet> inside;
};

struct SheetPort {
  int block = 0, port = 0;  // counted from 0
  friend bool operator==(const SheetPort&, const SheetPort&) = default;
};

// An output of a block and everything that reads it.
struct SheetWire {
  SheetPort from;
  std::vector<SheetPort> to;
  std::string label;      // above the wire where it begins
  std::string result;     // at its end, where it leaves the sheet
  std::string note;       // behind the label, smaller: a size, a value
  bool is_shown = false;  // a result of the diagram: forward paths lead to it
};

struct Sheet {
  std::string title;
  std::string path;  // of what is drawn, with a dot at its end: "plant."; empty for a whole diagram
  std::vector<SheetBlock> blocks;
  std::vector<SheetWire> wires;
};

// What a user may say about a place, when the automatic one is not wanted.
struct SheetHint {
  std::string path;  // from the top of the diagram: "plant.filter"
  enum class Where { forward, feedback } where = Where::forward;
};

}  // namespace plantloop
