// Formulas on the faces of blocks: fractions, powers and conditions, set from labels.

#pragma once

#include <string>
#include <vector>

#include "render/geometry/curve.h"
#include "render/scene/scene.h"

namespace plantloop {

// A formula as a tree. Texts follow the markup of labels (render/figure.h).
struct Formula {
  enum class Kind {
    text,      // `text`
    row,       // the parts side by side
    fraction,  // parts[0] over parts[1]
    power,     // parts[0] with parts[1] raised
    cases,     // the parts below each other behind a brace, each a row
    lines,     // the parts below each other, centred
  };
  Kind kind = Kind::text;
  std::string text;
  std::vector<Formula> parts;

  Formula() = default;
  Formula(std::string words) : text(std::move(words)) {}  // NOLINT: a text is a formula
  Formula(const char* words) : text(words) {}             // NOLINT
  Formula(Kind k, std::vector<Formula> p) : kind(k), parts(std::move(p)) {}
  bool empty() const { return kind == Kind::text ? text.empty() : parts.empty(); }
};

// What a formula takes, in pixels: from its left end, and above and below the base line.
struct FormulaSize {
  double width = 0, above = 0, below = 0;
  double height() const { return above + below; }
};
FormulaSize measure(const Formula& formula, double text_size);

// Sets the formula with its left end at x and its base line at y.
void set_formula(Group& into, const Formula& formula, double text_size, double x, double y, Color color,
                 Color background);

// The formula as one line of text, for readers that do not see.
std::string spoken(const Formula& formula);

}  // namespace plantloop
