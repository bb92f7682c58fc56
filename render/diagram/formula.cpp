// Measures and places the parts of a formula; fractions stand on the height of a minus sign.

#include "render/diagram/formula.h"

#include <algorithm>

#include "render/text/label.h"

namespace plantloop {
namespace {

constexpr double axis_height = 0.36;   // of the fraction's bar above the base line, in parts of the text size
constexpr double bar_gap = 0.24;       // between bar and parts
constexpr double bar_overhang = 0.18;  // of the bar beyond the wider part
constexpr double raised = 0.42;        // a power's base line above the base line
constexpr double small = 0.73;         // size of what is raised
constexpr double line_gap = 0.32;      // between lines
constexpr double brace_width = 0.55;
constexpr double smallest = 8;  // pixels

double smaller(double size) { return std::max(smallest, size * small); }

void bar(Group& into, double x0, double x1, double y, double width, Color color) {
  Stroke stroke;
  stroke.lines = {{to_point({x0, y}), to_point({x1, y})}};
  stroke.width = to_fixed(width);
  stroke.color = color;
  into.add({std::move(stroke)});
}

// A left brace from `top` to `bottom`, drawn as two arcs on each side of its nose.
void brace(Group& into, double x, double top, double bottom, double width, double thick, Color color) {
  const double middle = (top + bottom) / 2, stem = x + width / 2;
  Curve curve;
  const auto arc = [&](Spot from, Spot bend, Spot to) {
    for (int i = 0; i <= 6; ++i) {
      const double t = i / 6.0, u = 1 - t;
      curve.push_back(
          {u * u * from.x + 2 * u * t * bend.x + t * t * to.x, u * u * from.y + 2 * u * t * bend.y + t * t * to.y});
    }
  };
  const double r = std::min(width / 2, (bottom - top) / 4);
  arc({stem + r, top}, {stem, top}, {stem, top + r});
  arc({stem, middle - r}, {stem, middle}, {stem - r, middle});
  arc({stem - r, middle}, {stem, middle}, {stem, middle + r});
  arc({stem, bottom - r}, {stem, bottom}, {stem + r, bottom});
  Stroke stroke;
  stroke.lines = {to_polyline(curve)};
  stroke.width = to_fixed(thick);
  stroke.color = color;
  into.add({std::move(stroke)});
}

}  // namespace

FormulaSize measure(const Formula& f, double size) {
  FormulaSize result;
  switch (f.kind) {
    case Formula::Kind::text: {
      const Label label = set_label(f.text, {.size = size});
      return {label.width, std::max(cap_height * size, -label.top), std::max(0.0, label.bottom)};
    }
    case Formula::Kind::row:
      for (const Formula& part : f.parts) {
        const FormulaSize s = measure(part, size);
        result = {result.width + s.width, std::max(result.above, s.above), std::max(result.below, s.below)};
      }
      return result;
    case Formula::Kind::fraction: {
      const FormulaSize a = measure(f.parts[0], size), b = measure(f.parts[1], size);
      return {std::max(a.width, b.width) + 2 * bar_overhang * size, a.height() + (axis_height + bar_gap) * size,
              b.height() + (bar_gap - axis_height) * size};
    }
    case Formula::Kind::power: {
      const FormulaSize a = measure(f.parts[0], size), b = measure(f.parts[1], smaller(size));
      return {a.width + b.width + 0.04 * size, std::max(a.above, b.above + raised * size), a.below};
    }
    case Formula::Kind::cases:
    case Formula::Kind::lines: {
      double height = -line_gap * size;
      for (const Formula& part : f.parts) {
        const FormulaSize s = measure(part, size);
        result.width = std::max(result.width, s.width);
        height += s.height() + line_gap * size;
      }
      if (f.kind == Formula::Kind::cases) result.width += brace_width * size;
      result.above = height / 2 + axis_height * size;
      result.below = height / 2 - axis_height * size;
      return result;
    }
  }
  return result;
}

void set_formula(Group& into, const Formula& f, double size, double x, double y, Color color, Color background) {
  const double thick = std::max(1.0, size / 13);
  switch (f.kind) {
    case Formula::Kind::text: {
      const Label label = set_label(f.text, {.size = size});
      if (!label.empty()) into.add({place(label, x, y, 0, color, background)});
      return;
    }
    case Formula::Kind::row:
      for (const Formula& part : f.parts) {
        set_formula(into, part, size, x, y, color, background);
        x += measure(part, size).width;
      }
      return;
    case Formula::Kind::fraction: {
      const FormulaSize whole = measure(f, size), a = measure(f.parts[0], size), b = measure(f.parts[1], size);
      const double at = y - axis_height * size;
      set_formula(into, f.parts[0], size, x + (whole.width - a.width) / 2, at - bar_gap * size - a.below, color,
                  background);
      set_formula(into, f.parts[1], size, x + (whole.width - b.width) / 2, at + bar_gap * size + b.above, color,
                  background);
      bar(into, x, x + whole.width, at, thick, color);
      return;
    }
    case Formula::Kind::power: {
      set_formula(into, f.parts[0], size, x, y, color, background);
      set_formula(into, f.parts[1], smaller(size), x + measure(f.parts[0], size).width + 0.04 * size, y - raised * size,
                  color, background);
      return;
    }
    case Formula::Kind::cases:
    case Formula::Kind::lines: {
      const FormulaSize whole = measure(f, size);
      double top = y - whole.above;
      const double left = f.kind == Formula::Kind::cases ? brace_width * size : 0;
      if (left > 0) brace(into, x, top, y + whole.below, left, thick, color);
      for (const Formula& part : f.parts) {
        const FormulaSize s = measure(part, size);
        const double shift = f.kind == Formula::Kind::lines ? (whole.width - s.width) / 2 : 0;
        set_formula(into, part, size, x + left + shift, top + s.above, color, background);
        top += s.height() + line_gap * size;
      }
      return;
    }
  }
}

std::string spoken(const Formula& f) {
  switch (f.kind) {
    case Formula::Kind::text:
      return f.text;
    case Formula::Kind::fraction:
      return "(" + spoken(f.parts[0]) + ")/(" + spoken(f.parts[1]) + ")";
    case Formula::Kind::power:
      return spoken(f.parts[0]) + "^(" + spoken(f.parts[1]) + ")";
    default:
      break;
  }
  std::string result;
  for (const Formula& part : f.parts) {
    if (!result.empty() && f.kind != Formula::Kind::row) result += "; ";
    result += spoken(part);
  }
  return result;
}

}  // namespace plantloop
