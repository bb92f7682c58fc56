// What is known about the unit of a number, and what arithmetic makes of it.
//
// A literal takes any unit, as a summand and as a factor, so 0.001*x may be a conversion: its unit is not known.
// Nothing is ever guessed: what is not known stays so, and only two known units can clash.

#pragma once

#include <optional>
#include <string>

#include "engine/base/units.h"
#include "engine/program/operations.h"

namespace plantloop {

struct UnitFact {
  enum class Kind : std::uint8_t { unknown, literal, known };
  Kind kind = Kind::unknown;
  Unit unit;
  double number = 0;  // of a literal, for powers

  static UnitFact literal(double number) { return {Kind::literal, {}, number}; }
  static UnitFact known(const Unit& unit) { return {Kind::known, unit, 0}; }
  static UnitFact of_text(std::string_view text);  // "" is not known
  bool is_known() const { return kind == Kind::known; }
};

// Equal but for rounding of the factor.
bool same_unit(const Unit& a, const Unit& b);
// Whether two numbers that are added, compared or chosen from have units that differ.
bool clash(const UnitFact& a, const UnitFact& b);
// The unit of the result; of operands that clash it is not known.
UnitFact unit_after(Op op, const UnitFact& a, const UnitFact& b, const UnitFact& c);
// Both are values of one thing, as the branches of a choice.
UnitFact unit_of_either(const UnitFact& a, const UnitFact& b);
// The unit of the integral by time.
UnitFact times_seconds(const UnitFact& rate);

// A unit in words: its symbol where it has one, "V", else SI base units, "1000 kg m s^-2".
std::string unit_text(const Unit& unit);
// What makes of `text`, in the unit `from`, a number in `to`: "0.001*x"; nothing when the dimensions differ.
std::optional<std::string> conversion(const std::string& text, const Unit& from, const Unit& to);

}  // namespace plantloop
