// Filters by what a designer states: roots, or an order and cut-offs.

#pragma once

#include <vector>

#include "engine/block.h"

namespace plantloop {

// Roots of a polynomial, as parameters write them: a vector of real ones, or a matrix with a row [real, imaginary] for
// each one, conjugates included.
struct Roots {
  // Findings on rows of other lengths, missing conjugates, and more zeros than poles.
  static void check(Checking& checking, const Table& zeros, const Table& poles);
  // The shape of the polynomial with these roots.
  static Shape polynomial_shape(const Shape& roots);
  // (s - r1)(s - r2) ..., coefficients in descending powers.
  static Array polynomial(const Array& roots);
  // The polynomial of optional roots; 1 where there are none.
  static Array numerator(Now now, const Table& zeros) {
    return now.given(zeros) ? polynomial(now[zeros]) : Array(Shape::vector(1), 1.0);
  }
};

// The parameters of a Butterworth filter.
struct Butterworth {
  explicit Butterworth(Block* block);
  Choice kind;
  Count order;
  Number frequency, lower, upper;

  void check(Checking& checking) const;
  bool is_band() const { return kind.is("bandpass") || kind.is("bandstop"); }
  // Whether it is made of the highpasses of its sections.
  bool passes_high() const { return kind.is("highpass") || kind.is("bandstop"); }
  int poles() const { return is_band() ? 2 * order.value() : order.value(); }
  // The sections of the lowpass of cut-off 1: d for 1/(p^2 + d p + 1), first_order for 1/(p + 1).
  static constexpr double first_order = 0;
  std::vector<double> sections() const;
  Value cut_off(Now now) const { return now[frequency][0]; }                   // rad/s
  Value band(Now now) const { return now[upper][0] - now[lower][0]; }          // its width, rad/s
  Value centre(Now now) const { return sqrt(now[upper][0] * now[lower][0]); }  // rad/s
};

}  // namespace plantloop
