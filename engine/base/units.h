// Units: `kg m^2`, `N m/A`, `rad/s`. A unit is a claim about a number; numbers are never rescaled.
//
// A text is a product of factors with spaces between; `/` stands before each factor that divides (`J/kg/K`); `^` gives
// a factor an integer power. rad is 1. SI units and bar min h d deg rpm % l t eV, with prefixes where they are used.

#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

namespace plantloop {

struct Unit {
  // Powers of m kg s A K mol cd.
  std::array<std::int8_t, 7> dimension{};
  // A number in this unit times `factor`, plus `offset`, is the number in SI base units.
  double factor = 1;
  double offset = 0;  // of degC only

  bool same_dimension(const Unit& other) const { return dimension == other.dimension; }
  friend bool operator==(const Unit& a, const Unit& b) = default;
};

// What is wrong with a unit text: bytes [at, at + length) of it.
struct UnitError {
  std::string message;
  std::string hint;  // "" when there is none
  std::size_t at = 0;
  std::size_t length = 1;
};

// The unit that a text means; "" and "1" are the number one.
std::variant<Unit, UnitError> parse_unit(std::string_view text);

// Its SI base units, "kg m^2 s^-2"; "1" for a pure number.
std::string dimension_text(const Unit& unit);

}  // namespace plantloop
