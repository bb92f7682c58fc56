// Fractions, powers, roots and conditions; factors stand beside each other, with a dot where both are words.

#include "app/drawing/formulas.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <utility>

#include "engine/base/numbers.h"

namespace plantloop {
namespace {

using Kind = Expression::Kind;

constexpr std::array<std::pair<std::string_view, std::string_view>, 35> greek{{
    {"alpha", "α"}, {"beta", "β"},  {"gamma", "γ"}, {"delta", "δ"},  {"epsilon", "ε"}, {"zeta", "ζ"},   {"eta", "η"},
    {"theta", "θ"}, {"iota", "ι"},  {"kappa", "κ"}, {"lambda", "λ"}, {"mu", "μ"},      {"nu", "ν"},     {"xi", "ξ"},
    {"pi", "π"},    {"rho", "ρ"},   {"sigma", "σ"}, {"tau", "τ"},    {"upsilon", "υ"}, {"phi", "φ"},    {"chi", "χ"},
    {"psi", "ψ"},   {"omega", "ω"}, {"Gamma", "Γ"}, {"Delta", "Δ"},  {"Theta", "Θ"},   {"Lambda", "Λ"}, {"Xi", "Ξ"},
    {"Pi", "Π"},    {"Sigma", "Σ"}, {"Phi", "Φ"},   {"Psi", "Ψ"},    {"Omega", "Ω"},   {"inf", "∞"},    {"time", "t"},
}};

std::string_view letter_of(std::string_view name) {
  const auto* it = std::find_if(greek.begin(), greek.end(), [&](const auto& g) { return g.first == name; });
  return it == greek.end() ? std::string_view() : it->second;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// A symbol and its index: "theta0" -> {"θ", "0"}; nothing for a word.
std::optional<std::pair<std::string, std::string>> symbol(std::string_view name) {
  const auto base_of = [](std::string_view base) -> std::string {
    if (base.size() == 1) return std::string(base);
    return std::string(letter_of(base));
  };
  const std::size_t mark = name.find('_');
  if (mark != std::string_view::npos && mark > 0) {
    const std::string_view index = name.substr(mark + 1);
    const std::string base = base_of(name.substr(0, mark));
    if (!base.empty() && !index.empty() && index.size() <= 3 && index.find('_') == std::string_view::npos)
      return std::pair(base, std::string(index));
    return std::nullopt;
  }
  std::size_t end = name.size();
  while (end > 0 && is_digit(name[end - 1])) --end;
  if (const std::string base = base_of(name.substr(0, end)); !base.empty())
    return std::pair(base, std::string(name.substr(end)));
  // kp, Ki, Ts: a gain or a time with its index.
  if (name.size() == 2 && (name[0] == 'k' || name[0] == 'K' || name[0] == 'T') && std::islower(name[1]) != 0)
    return std::pair(std::string(1, name[0]), std::string(1, name[1]));
  return std::nullopt;
}

std::string with_index(const std::string& base, const std::string& index) {
  return index.empty() ? base : fmt::format("{}_{{{}}}", base, index);
}

int rank_of(const Expression& e) {
  if (e.kind == Kind::unary) return e.text == "not" ? 3 : 6;
  if (e.kind == Kind::number) return e.number < 0 ? 6 : 9;
  if (e.kind != Kind::binary) return 9;
  if (e.text == "or") return 1;
  if (e.text == "and") return 2;
  if (e.text == "+" || e.text == "-") return 5;
  if (e.text == "*" || e.text == "/") return 7;
  if (e.text == "^") return 8;
  return 4;  // comparisons
}

Formula row(std::vector<Formula> parts) { return {Formula::Kind::row, std::move(parts)}; }

bool is_flat(const Formula& f) {
  if (f.kind == Formula::Kind::text) return true;
  return f.kind == Formula::Kind::row && std::all_of(f.parts.begin(), f.parts.end(), is_flat);
}

bool is_sum(const Formula& f) {
  return f.kind == Formula::Kind::row && std::any_of(f.parts.begin(), f.parts.end(), [](const Formula& part) {
           return part.kind == Formula::Kind::text && (part.text == " + " || part.text == " − ");
         });
}

class Setter {
 public:
  explicit Setter(const Substitute& substitute) : substitute_(substitute) {}

  // `least`: a part that binds less gets brackets.
  Formula set(const Expression& whole, int least) const {
    const Expression& e = without_ones(whole);
    if (e.kind == Kind::name && substitute_)
      if (std::optional<Formula> other = substitute_(e, least > 5)) return *std::move(other);
    Formula f = plain(e);
    if (rank_of(e) < least && !(f.kind == Formula::Kind::fraction && least <= 7)) return row({"(", std::move(f), ")"});
    return f;
  }

 private:
  Formula plain(const Expression& e) const {
    switch (e.kind) {
      case Kind::number:
        return pretty_number(e.number);
      case Kind::name:
        return name(e);
      case Kind::unary:
        return row({e.text == "not" ? "not "
                    : e.text == "-" ? "−"
                                    : "",
                    set(*e.arguments[0], e.text == "not" ? 3 : 6)});
      case Kind::binary:
        return binary(e);
      case Kind::call:
        return call(e);
      case Kind::vector:
        return list("[", e, "]");
    }
    return {};
  }

  static Formula name(const Expression& e) {
    // Elements are indices of the name before them.
    std::size_t names = e.parts.size();
    while (names > 1 && is_digit(e.parts[names - 1][0])) --names;
    std::string index;
    for (std::size_t i = names; i < e.parts.size(); ++i) index += (index.empty() ? "" : ",") + e.parts[i];
    if (e.slice_end > 0) index += fmt::format("…{}", e.slice_end);
    const std::string& last = e.parts[names - 1];
    if (index.empty()) return pretty_name(last);
    const auto known = symbol(last);
    if (!known) return fmt::format("{}_{{{}}}", pretty_name(last), index);
    return with_index(known->first, known->second.empty() ? index : known->second + "," + index);
  }

  static bool is_word(const Expression& e) {
    const Expression* x = &e;
    while (x->kind == Kind::binary && (x->text == "*")) x = x->arguments[1].get();
    return (x->kind == Kind::name && !is_symbol(x->parts.back())) || x->kind == Kind::call;
  }
  static bool starts_with_number(const Expression& e) {
    const Expression* x = &e;
    while (x->kind == Kind::binary && x->text == "*") x = x->arguments[0].get();
    return x->kind == Kind::number ||
           (x->kind == Kind::binary && x->text == "^" && x->arguments[0]->kind == Kind::number);
  }

  static bool begins_with_digit(const Formula& f) {
    if (f.kind == Formula::Kind::text) return !f.text.empty() && is_digit(f.text[0]);
    const bool flat = f.kind == Formula::Kind::row || f.kind == Formula::Kind::power;
    return flat && !f.parts.empty() && begins_with_digit(f.parts[0]);
  }

  // A factor that need not be written.
  bool is_one(const Expression& e) const {
    if (e.kind == Kind::number) return e.number == 1;
    if (e.kind != Kind::name || !substitute_) return false;
    const std::optional<Formula> other = substitute_(e, true);
    return other && other->kind == Formula::Kind::text && other->text == "1";
  }

  const Expression& without_ones(const Expression& e) const {
    if (e.kind != Kind::binary || e.text != "*") return e;
    if (is_one(*e.arguments[0])) return without_ones(*e.arguments[1]);
    if (is_one(*e.arguments[1])) return without_ones(*e.arguments[0]);
    return e;
  }

  Formula binary(const Expression& e) const {
    const Expression &a = *e.arguments[0], &b = *e.arguments[1];
    if (e.text == "/") {
      Formula over = set(a, 0), under = set(b, 0);
      return {Formula::Kind::fraction, {std::move(over), std::move(under)}};
    }
    if (e.text == "^") return {Formula::Kind::power, {set(a, 9), set(b, 0)}};
    if (e.text == "*") {
      // −1 s is −s.
      if (a.kind == Kind::unary && a.text == "-" && is_one(*a.arguments[0])) return row({"−", set(b, 7)});
      // (1/p) s is s/p.
      if (Formula first = set(a, 6), second = set(b, 7); first.kind == Formula::Kind::fraction && is_flat(second)) {
        const bool one = first.parts[0].kind == Formula::Kind::text && first.parts[0].text == "1";
        if (is_sum(first.parts[0])) first.parts[0] = row({"(", first.parts[0], ")"});
        first.parts[0] = one ? second : row({first.parts[0], " ", second});
        return first;
      }
      // What stands there decides: a name may have been replaced by a number.
      Formula first = set(a, 6), second = set(b, 7);
      const bool word = (is_word(a) && !begins_with_digit(first)) || (is_word(b) && !begins_with_digit(second));
      const bool dot = word || begins_with_digit(second) || starts_with_number(b);
      return row({std::move(first), dot ? " · " : " ", std::move(second)});
    }
    if (e.text == "+" || e.text == "-")
      return row({set(a, 5), e.text == "+" ? " + " : " − ", set(b, e.text == "-" ? 6 : 5)});
    const std::pair<std::string_view, const char*> signs[] = {{"<=", " ≤ "}, {">=", " ≥ "}, {"==", " = "},
                                                              {"!=", " ≠ "}, {"<", " < "},  {">", " > "}};
    for (const auto& [text, sign] : signs)
      if (e.text == text) return row({set(a, 5), sign, set(b, 5)});
    const int own = rank_of(e);
    return row({set(a, own), " " + e.text + " ", set(b, own)});
  }

  Formula list(const std::string& open, const Expression& e, const std::string& close) const {
    std::vector<Formula> parts{open};
    for (std::size_t i = 0; i < e.arguments.size(); ++i) {
      if (i > 0) parts.emplace_back(", ");
      parts.push_back(set(*e.arguments[i], 0));
    }
    parts.emplace_back(close);
    return row(std::move(parts));
  }

  // One below the other, however many are nested behind each other's else.
  Formula cases(const Expression& e) const {
    std::vector<Formula> lines;
    const Expression* rest = &e;
    for (; rest->kind == Kind::call && rest->text == "where" && rest->arguments.size() == 3;
         rest = rest->arguments[2].get())
      lines.push_back(row({set(*rest->arguments[1], 0), "  if ", set(*rest->arguments[0], 0)}));
    lines.push_back(row({set(*rest, 0), "  else"}));
    return {Formula::Kind::cases, std::move(lines)};
  }

  Formula call(const Expression& e) const {
    if (e.text == "where" && e.arguments.size() == 3) return cases(e);
    if (e.text == "abs" && e.arguments.size() == 1) return row({"|", set(*e.arguments[0], 0), "|"});
    if (e.text == "exp" && e.arguments.size() == 1) {
      Formula power = set(*e.arguments[0], 0);
      if (is_flat(power)) return {Formula::Kind::power, {"e", std::move(power)}};
    }
    if (e.text == "sqrt" && e.arguments.size() == 1) {
      const Formula inside = set(*e.arguments[0], 9);
      const bool bracketed = rank_of(*e.arguments[0]) < 9 || e.arguments[0]->kind == Kind::call;
      return row({"√", bracketed && rank_of(*e.arguments[0]) >= 9 ? row({"(", inside, ")"}) : inside});
    }
    return list(e.text + "(", e, ")");
  }

  const Substitute& substitute_;
};

}  // namespace

bool is_symbol(std::string_view name) { return symbol(name).has_value(); }

std::string pretty_name(std::string_view name) {
  if (const auto s = symbol(name)) return with_index(s->first, s->second);
  std::string words(name);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

std::string pretty_number(double value) {
  if (std::isinf(value)) return value > 0 ? "∞" : "−∞";
  std::string text = shortest(std::abs(value));
  const std::string sign = value < 0 ? "−" : "";
  const std::size_t e = text.find('e');
  if (e == std::string::npos) return sign + text;
  const std::string mantissa = text.substr(0, e);
  const long exponent = parse_integer(text.substr(e + 1 + (text[e + 1] == '+' ? 1 : 0))).value_or(0);
  const std::string power = fmt::format("10^{{{}{}}}", exponent < 0 ? "−" : "", std::abs(exponent));
  return sign + (mantissa == "1" ? power : mantissa + "·" + power);
}

Formula formula_of(const Expression& expression, const Substitute& substitute, bool is_factor) {
  return Setter(substitute).set(expression, is_factor ? 6 : 0);
}

Formula polynomial(const std::vector<Formula>& coefficients, const std::vector<std::optional<double>>& numbers,
                   const std::string& variable) {
  std::vector<Formula> parts;
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    const std::size_t power = coefficients.size() - 1 - i;
    std::optional<double> number = numbers[i];
    if (number && *number == 0 && coefficients.size() > 1) continue;
    const bool minus = number && *number < 0;
    if (!parts.empty() || minus) parts.emplace_back(parts.empty() ? "−" : minus ? " − " : " + ");
    const bool shown = power == 0 || !number || std::abs(*number) != 1;
    if (shown) parts.push_back(number ? Formula(pretty_number(std::abs(*number))) : coefficients[i]);
    if (power == 0) continue;
    if (shown) parts.emplace_back(" ");
    parts.emplace_back(power == 1 ? variable : fmt::format("{}^{{{}}}", variable, power));
  }
  if (parts.empty()) return "0";
  return row(std::move(parts));
}

}  // namespace plantloop
