// Where an axis is labelled, and with which words.
//
// Linear ticks are whole multiples of a step m 10^e with a small whole m, kept as integers: labels are exact decimals
// and never show the noise of binary fractions. The choice follows J. Talbot, S. Lin, P. Hanrahan, "An extension of
// Wilkinson's algorithm for positioning tick labels on axes" (2010), restricted to multiples of the step.

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/figure.h"

namespace plantloop {

struct Tick {
  double value = 0;
  std::string label;  // markup of render/figure.h; empty for a minor tick
};

// An axis: its ends and its ticks.
struct Ruler {
  Scale scale = Scale::linear;
  double lower = 0, upper = 1;
  std::vector<Tick> ticks;
  std::vector<double> minor;  // between the ticks of a logarithmic axis
  double threshold = 1;       // of a symmetric logarithmic axis: straight between minus and plus this
  bool named = false;         // the ticks are names, not numbers
  int exponent = 0;           // the labels are to be multiplied by ten to this ...
  double offset = 0;          // ... and this is to be added
  std::string note;           // "×10^{3}", "+ 1000000": what stands in the corner; mostly empty
};

struct RulerWish {
  Scale scale = Scale::linear;
  Limits limits;          // from the user
  double data_lower = 0;  // of the data; data_lower > data_upper when there are none
  double data_upper = 0;
  double length = 500;           // pixels
  double spacing = 70;           // pixels between labels, wanted
  double gap = 22;               // pixels between labels, at least
  bool tight = false;            // end where the data end (a time axis), instead of at a tick
  bool degrees = false;          // prefer 15, 30, 45, 90
  int intervals = 0;             // when positive: exactly as many as this (a twin axis shares the other's grid lines)
  int intervals_below_zero = 0;  // of the other axis: zero stands at the same height when there is room for that
  double threshold = 0;          // of a symmetric logarithmic axis; 0: found
  const std::vector<AxisTick>* named = nullptr;  // ticks that the user gives
  int every = 1;                                 // of these, every so manieth
};

Ruler make_ruler(const RulerWish& wish);

// The ticks of a linear axis between fixed ends, about `target` of them.
void set_ticks(Ruler& ruler, double target, bool degrees);

// Where a value lies: 0 at the lower end, 1 at the upper. NaN for what a logarithmic axis cannot show.
double position(const Ruler& ruler, double value);

}  // namespace plantloop
