// Units: texts to dimensions.

#include "engine/base/units.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "engine/base/numbers.h"
#include "engine/base/report.h"
#include "engine/base/text.h"

namespace plantloop {
namespace {

struct Known {
  std::string_view name;
  std::array<std::int8_t, 7> dimension;
  double factor = 1;
  bool prefixes = false;
  double offset = 0;
};

constexpr double pi = std::numbers::pi;

// The SI brochure, 9th edition, tables 2, 4 and 8; rpm, % and ppm are what data sheets use.
const std::vector<Known>& known_units() {
  //                      m  kg s  A  K mol cd
  static const std::vector<Known> list{
      {"1", {}},
      {"m", {1}, 1, true},
      {"g", {0, 1}, 1e-3, true},
      {"s", {0, 0, 1}, 1, true},
      {"A", {0, 0, 0, 1}, 1, true},
      {"K", {0, 0, 0, 0, 1}, 1, true},
      {"mol", {0, 0, 0, 0, 0, 1}, 1, true},
      {"cd", {0, 0, 0, 0, 0, 0, 1}, 1, true},
      {"rad", {}, 1, true},
      {"sr", {}},
      {"deg", {}, pi / 180},
      {"°", {}, pi / 180},
      {"turn", {}, 2 * pi},
      {"%", {}, 1e-2},
      {"ppm", {}, 1e-6},
      {"Hz", {0, 0, -1}, 1, true},
      {"rpm", {0, 0, -1}, 2 * pi / 60},
      {"N", {1, 1, -2}, 1, true},
      {"Pa", {-1, 1, -2}, 1, true},
      {"bar", {-1, 1, -2}, 1e5, true},
      {"atm", {-1, 1, -2}, 101325},
      {"J", {2, 1, -2}, 1, true},
      {"eV", {2, 1, -2}, 1.602176634e-19, true},
      {"cal", {2, 1, -2}, 4.184, true},
      {"W", {2, 1, -3}, 1, true},
      {"C", {0, 0, 1, 1}, 1, true},
      {"V", {2, 1, -3, -1}, 1, true},
      {"F", {-2, -1, 4, 2}, 1, true},
      {"Ohm", {2, 1, -3, -2}, 1, true},
      {"ohm", {2, 1, -3, -2}, 1, true},
      {"Ω", {2, 1, -3, -2}, 1, true},
      {"S", {-2, -1, 3, 2}, 1, true},
      {"Wb", {2, 1, -2, -1}, 1, true},
      {"T", {0, 1, -2, -1}, 1, true},
      {"H", {2, 1, -2, -2}, 1, true},
      {"lm", {0, 0, 0, 0, 0, 0, 1}, 1, true},
      {"lx", {-2, 0, 0, 0, 0, 0, 1}, 1, true},
      {"Bq", {0, 0, -1}, 1, true},
      {"Gy", {2, 0, -2}, 1, true},
      {"Sv", {2, 0, -2}, 1, true},
      {"kat", {0, 0, -1, 0, 0, 1}, 1, true},
      {"degC", {0, 0, 0, 0, 1}, 1, false, 273.15},
      {"°C", {0, 0, 0, 0, 1}, 1, false, 273.15},
      {"min", {0, 0, 1}, 60},
      {"h", {0, 0, 1}, 3600},
      {"d", {0, 0, 1}, 86400},
      {"l", {3}, 1e-3, true},
      {"L", {3}, 1e-3, true},
      {"t", {0, 1}, 1e3},
  };
  return list;
}

struct Prefix {
  std::string_view name;
  double factor;
};
constexpr Prefix prefixes[] = {{"da", 1e1}, {"Y", 1e24}, {"Z", 1e21},  {"E", 1e18},  {"P", 1e15},
                               {"T", 1e12}, {"G", 1e9},  {"M", 1e6},   {"k", 1e3},   {"h", 1e2},
                               {"d", 1e-1}, {"c", 1e-2}, {"m", 1e-3},  {"u", 1e-6},  {"µ", 1e-6},
                               {"μ", 1e-6}, {"n", 1e-9}, {"p", 1e-12}, {"f", 1e-15}, {"a", 1e-18}};

std::optional<Unit> find_unit(std::string_view name) {
  for (const Known& known : known_units()) {
    if (known.name == name) return Unit{known.dimension, known.factor, known.offset};
  }
  for (const Prefix& prefix : prefixes) {
    if (!name.starts_with(prefix.name)) continue;
    for (const Known& known : known_units()) {
      if (known.prefixes && known.name == name.substr(prefix.name.size())) {
        return Unit{known.dimension, prefix.factor * known.factor};
      }
    }
  }
  return std::nullopt;
}

UnitError unknown_unit(std::string_view name, std::size_t at) {
  UnitError error{.message = fmt::format("there is no unit '{}'", name), .hint = {}, .at = at, .length = name.size()};
  std::vector<std::string> names;
  for (const Known& known : known_units()) names.emplace_back(known.name);
  names.emplace_back("kg");
  const std::string near = nearest(name, names);
  if (!near.empty()) error.hint = fmt::format("did you mean '{}'?", near);
  const auto has = [&](std::string_view part) { return name.find(part) != std::string_view::npos; };
  if (has("²") || has("³")) error.hint = "a power is written with ^: m^2";
  if (has("·") || has(".")) error.hint = "a product of units is written with a space: N m";
  constexpr std::pair<std::string_view, std::string_view> spelled[] = {
      {"meter", "m"},      {"metre", "m"},  {"second", "s"},   {"sec", "s"},      {"seconds", "s"},   {"volt", "V"},
      {"ampere", "A"},     {"amp", "A"},    {"newton", "N"},   {"pascal", "Pa"},  {"watt", "W"},      {"joule", "J"},
      {"kelvin", "K"},     {"hour", "h"},   {"minute", "min"}, {"degree", "deg"}, {"degrees", "deg"}, {"radian", "rad"},
      {"celsius", "degC"}, {"litre", "l"},  {"liter", "l"},    {"percent", "%"},  {"ms-1", "m/s"},    {"kmh", "km/h"},
      {"kph", "km/h"},     {"hertz", "Hz"}, {"gram", "g"},     {"-", "1"}};
  for (const auto& [word, symbol] : spelled) {
    if (word == name) error.hint = fmt::format("write {}", symbol);
  }
  return error;
}

// Reads the factors one after another; the position stays at the first byte that is not understood.
class UnitParser {
 public:
  explicit UnitParser(std::string_view text) : text_(text) {}

  std::variant<Unit, UnitError> parse() {
    skip_spaces();
    if (at_ == text_.size()) return Unit{};
    while (at_ < text_.size()) {
      if (auto error = factor()) return *error;
      skip_spaces();
    }
    if (factors_ > 1 && unit_.offset != 0) {
      return UnitError{"degrees Celsius cannot be part of a product, because their zero is not zero", "write K", 0,
                       text_.size()};
    }
    return unit_;
  }

 private:
  void skip_spaces() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
  }

  std::optional<UnitError> factor() {
    int sign = 1;
    if (text_[at_] == '/') {
      if (factors_ == 0) return UnitError{"a unit does not begin with '/'", "write 1/s", at_, 1};
      sign = -1;
      ++at_;
      skip_spaces();
    }
    const std::size_t start = at_;
    while (at_ < text_.size() && std::string_view(" /^*()").find(text_[at_]) == std::string_view::npos) ++at_;
    const std::string_view name = text_.substr(start, at_ - start);
    if (name.empty()) return nothing_here(start);
    const auto unit = find_unit(name);
    if (!unit) return unknown_unit(name, start);
    int power = 1;
    if (at_ < text_.size() && text_[at_] == '^') {
      const std::size_t digits = ++at_;
      if (at_ < text_.size() && text_[at_] == '-') ++at_;
      while (at_ < text_.size() && is_digit(text_[at_])) ++at_;
      const auto value = parse_integer(text_.substr(digits, at_ - digits));
      if (!value || *value < -12 || *value > 12) {
        return UnitError{"after '^' a unit has an integer power", "for example m^2 or s^-1", digits - 1,
                         at_ - digits + 1};
      }
      power = static_cast<int>(*value);
    }
    return multiply(*unit, sign * power, start);
  }

  std::optional<UnitError> nothing_here(std::size_t at) const {
    if (at == text_.size()) return UnitError{"the unit ends after '/'", "", at > 0 ? at - 1 : 0, 1};
    const char c = text_[at];
    const std::size_t length = character_length(text_, at);
    if (c == '(' || c == ')') {
      return UnitError{"units have no brackets", "'/' stands before each factor that divides: J/kg/K", at, 1};
    }
    if (c == '/' || c == '^') return UnitError{fmt::format("'{}' stands where a unit was expected", c), "", at, 1};
    return UnitError{"a product of units is written with a space", "for example N m", at, length};
  }

  std::optional<UnitError> multiply(const Unit& unit, int power, std::size_t at) {
    ++factors_;
    for (std::size_t i = 0; i < unit.dimension.size(); ++i) {
      const int sum = unit_.dimension[i] + unit.dimension[i] * power;
      if (sum < -100 || sum > 100) return UnitError{"the powers of this unit are too large", "", at, 1};
      unit_.dimension[i] = static_cast<std::int8_t>(sum);
    }
    unit_.factor *= std::pow(unit.factor, power);
    if (unit.offset != 0) {
      unit_.offset = unit.offset;
      if (power != 1) ++factors_;  // as bad as a product
    }
    return std::nullopt;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t factors_ = 0;
  Unit unit_;
};

}  // namespace

std::variant<Unit, UnitError> parse_unit(std::string_view text) { return UnitParser(text).parse(); }

std::string dimension_text(const Unit& unit) {
  constexpr std::string_view names[] = {"m", "kg", "s", "A", "K", "mol", "cd"};
  std::string out;
  for (std::size_t i = 0; i < unit.dimension.size(); ++i) {
    if (unit.dimension[i] == 0) continue;
    if (!out.empty()) out += ' ';
    out += names[i];
    if (unit.dimension[i] != 1) out += fmt::format("^{}", unit.dimension[i]);
  }
  return out.empty() ? "1" : out;
}

}  // namespace plantloop
