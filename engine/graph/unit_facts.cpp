// The algebra of units. Products of temperatures with a zero of their own (degC) are not known.

#include "engine/graph/unit_facts.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "engine/base/numbers.h"

namespace plantloop {
namespace {

bool nearly(double a, double b) { return std::fabs(a - b) <= 1e-9 * std::fabs(b); }

const UnitFact unknown;

UnitFact pure_number() { return UnitFact::known(Unit{}); }

UnitFact product(const UnitFact& a, const UnitFact& b, int sign) {
  if (a.kind == UnitFact::Kind::literal && b.kind == UnitFact::Kind::literal) return UnitFact::literal(0);
  if (!a.is_known() || !b.is_known() || a.unit.offset != 0 || b.unit.offset != 0) return unknown;
  Unit unit = a.unit;
  for (std::size_t i = 0; i < unit.dimension.size(); ++i)
    unit.dimension[i] = static_cast<std::int8_t>(unit.dimension[i] + sign * b.unit.dimension[i]);
  unit.factor *= sign > 0 ? b.unit.factor : 1 / b.unit.factor;
  return UnitFact::known(unit);
}

// Where every power of the result is whole.
UnitFact power(const UnitFact& a, double exponent) {
  if (!a.is_known() || a.unit.offset != 0) return unknown;
  Unit unit;
  for (std::size_t i = 0; i < unit.dimension.size(); ++i) {
    const double power = a.unit.dimension[i] * exponent;
    if (power != std::round(power) || std::fabs(power) > 100) return unknown;
    unit.dimension[i] = static_cast<std::int8_t>(power);
  }
  unit.factor = std::pow(a.unit.factor, exponent);
  return UnitFact::known(unit);
}

UnitFact sum(const UnitFact& a, const UnitFact& b) {
  const bool left = a.is_known() && a.unit.offset != 0, right = b.is_known() && b.unit.offset != 0;
  if (left && right) return unknown;
  if (left && b.is_known()) return a;  // a temperature and a difference
  if (right && a.is_known()) return b;
  return unit_of_either(a, b);
}

UnitFact difference(const UnitFact& a, const UnitFact& b) {
  const bool left = a.is_known() && a.unit.offset != 0, right = b.is_known() && b.unit.offset != 0;
  if (left && right) {
    Unit kelvin = a.unit;
    kelvin.offset = 0;
    return same_unit(a.unit, b.unit) ? UnitFact::known(kelvin) : unknown;
  }
  if (right) return unknown;
  return left ? a : unit_of_either(a, b);
}

UnitFact without_offset(const UnitFact& a) { return a.is_known() && a.unit.offset != 0 ? unknown : a; }

bool is_function_of_number(Op op) {
  switch (op) {
    case Op::exp:
    case Op::log:
    case Op::log2:
    case Op::log10:
    case Op::sin:
    case Op::cos:
    case Op::tan:
    case Op::asin:
    case Op::acos:
    case Op::atan:
    case Op::sinh:
    case Op::cosh:
    case Op::tanh:
    case Op::asinh:
    case Op::acosh:
    case Op::atanh:
    case Op::erf:
    case Op::sign:
      return true;
    default:
      return false;
  }
}

}  // namespace

UnitFact UnitFact::of_text(std::string_view text) {
  if (text.empty()) return {};
  const auto unit = parse_unit(text);
  return std::holds_alternative<Unit>(unit) ? known(std::get<Unit>(unit)) : UnitFact{};
}

bool same_unit(const Unit& a, const Unit& b) {
  return a.same_dimension(b) && nearly(a.factor, b.factor) && a.offset == b.offset;
}

bool clash(const UnitFact& a, const UnitFact& b) { return a.is_known() && b.is_known() && !same_unit(a.unit, b.unit); }

UnitFact unit_of_either(const UnitFact& a, const UnitFact& b) {
  if (clash(a, b)) return unknown;
  if (a.is_known()) return a;
  if (b.is_known()) return b;
  return a.kind == UnitFact::Kind::literal && b.kind == UnitFact::Kind::literal ? UnitFact::literal(0) : unknown;
}

UnitFact times_seconds(const UnitFact& rate) { return product(rate, UnitFact::of_text("s"), 1); }

UnitFact unit_after(Op op, const UnitFact& a, const UnitFact& b, const UnitFact& c) {
  switch (op) {
    case Op::copy:
    case Op::floor:
    case Op::ceil:
    case Op::round:
    case Op::trunc:
      return a;
    case Op::neg:
      if (a.kind == UnitFact::Kind::literal) return UnitFact::literal(-a.number);
      return without_offset(a);
    case Op::abs:
      return without_offset(a);
    case Op::sqrt:
      return a.kind == UnitFact::Kind::literal ? a : power(a, 0.5);
    case Op::cbrt:
      return a.kind == UnitFact::Kind::literal ? a : power(a, 1.0 / 3);
    case Op::add:
      return sum(a, b);
    case Op::sub:
      return difference(a, b);
    case Op::mul:
      return product(a, b, 1);
    case Op::div:
      return product(a, b, -1);
    case Op::pow:
      if (a.kind == UnitFact::Kind::literal && b.kind == UnitFact::Kind::literal) return a;
      return b.kind == UnitFact::Kind::literal ? power(a, b.number) : unknown;
    case Op::min:
    case Op::max:
    case Op::hypot:
    case Op::mod:
      return unit_of_either(a, b);
    case Op::where:
      return unit_of_either(b, c);
    case Op::atan2:
    case Op::less:
    case Op::less_equal:
    case Op::equal:
    case Op::logical_and:
    case Op::logical_or:
    case Op::logical_not:
      return pure_number();
    default:
      break;
  }
  if (!is_function_of_number(op)) return unknown;
  return a.is_known() ? pure_number() : a.kind == UnitFact::Kind::literal ? a : unknown;
}

std::string unit_text(const Unit& unit) {
  constexpr const char* symbols[] = {"1",   "m",  "kg",  "g",   "s",   "A",   "K",     "mol", "N",    "Pa",  "J",  "W",
                                     "C",   "V",  "F",   "Ohm", "S",   "Wb",  "T",     "H",   "degC", "mm",  "cm", "km",
                                     "ms",  "us", "min", "h",   "d",   "bar", "kPa",   "kN",  "kW",   "mA",  "mV", "kV",
                                     "deg", "%",  "rpm", "l",   "1/s", "m/s", "m/s^2", "N m", "km/h", "A/s", "V/s"};
  for (const char* symbol : symbols) {
    if (same_unit(unit, std::get<Unit>(parse_unit(symbol)))) return symbol;
  }
  const std::string base = dimension_text(unit);
  return nearly(unit.factor, 1) ? base : fmt::format("{} {}", shortest(unit.factor), base);
}

std::optional<std::string> conversion(const std::string& text, const Unit& from, const Unit& to) {
  if (!from.same_dimension(to)) return std::nullopt;
  std::string factor;
  double ratio = from.factor / to.factor;
  if (const double rounded = std::round(ratio * 1e12) / 1e12; nearly(ratio, rounded)) ratio = rounded;
  if (const double inverse = std::round(to.factor / from.factor);
      inverse > 1 && nearly(to.factor / from.factor, inverse) && inverse < 1e15)
    ratio = 1 / inverse;
  if (!nearly(ratio, 1)) {
    constexpr double degree = std::numbers::pi / 180, turn = 2 * std::numbers::pi / 60;
    factor = nearly(ratio, degree)       ? "pi/180*"
             : nearly(ratio, 1 / degree) ? "180/pi*"
             : nearly(ratio, turn)       ? "pi/30*"
             : nearly(ratio, 1 / turn)   ? "30/pi*"
                                         : shortest(ratio) + "*";
  }
  const double shift = (from.offset - to.offset) / to.factor;
  std::string whole = factor + text;
  if (shift != 0) whole += fmt::format(" {} {}", shift > 0 ? "+" : "-", shortest(std::fabs(shift)));
  return whole;
}

}  // namespace plantloop
