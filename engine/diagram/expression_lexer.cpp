// Expression text -> tokens.

#include "engine/diagram/expression_lexer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <variant>

#include "engine/base/text.h"
#include "engine/base/units.h"

namespace plantloop {
namespace {

// What other languages write, what is meant, and how that is said. Longer ones first.
struct Foreign {
  std::string_view written, meant, words;
};
constexpr std::array foreign{
    Foreign{"&&", "and", "'and' is written as a word"},
    Foreign{"||", "or", "'or' is written as a word"},
    Foreign{"**", "^", "a power is written with ^"},
    Foreign{"~=", "!=", "'not equal' is written !="},
    Foreign{"<>", "!=", "'not equal' is written !="},
    Foreign{"=<", "<=", "'at most' is written <="},
    Foreign{"=>", ">=", "'at least' is written >="},
    Foreign{"//", "/", "a division is written with one /; floor(a/b) rounds it down"},
    Foreign{".*", "*", "* already goes element by element"},
    Foreign{"./", "/", "/ already goes element by element"},
    Foreign{".^", "^", "^ already goes element by element"},
    Foreign{"=", "==", "'equal' is written =="},
    Foreign{"&", "and", "'and' is written as a word"},
    Foreign{"|", "or", "'or' is written as a word"},
    Foreign{"!", "not", "'not' is written as a word"},
    Foreign{"~", "not", "'not' is written as a word"},
    Foreign{"−", "-", "this is a typographic minus; write -"},
    Foreign{"–", "-", "this is a dash; write -"},
    Foreign{"·", "*", "a product is written with *"},
    Foreign{"×", "*", "a product is written with *"},
    Foreign{"÷", "/", "a division is written with /"},
    Foreign{"≤", "<=", "'at most' is written <="},
    Foreign{"≥", ">=", "'at least' is written >="},
    Foreign{"≠", "!=", "'not equal' is written !="},
};

struct Stray {
  std::string_view written, words;
};
constexpr std::array strays{
    Stray{";", "rows of a matrix are vectors: [[1, 2], [3, 4]]"},
    Stray{"?", "a choice is written where(condition, a, b)"},
    Stray{":", "a slice has numbers on both sides: x.2:5"},
    Stray{"%", "the rest of a division is written mod(a, b)"},
    Stray{"'",
          "a transpose is written transpose(A); a derivative is the output of a filtered_derivative; a text is "
          "declared as a parameter, {text: ...}"},
    Stray{"\"", "a text is declared as a parameter, {text: ...}"},
    Stray{"$", "$name stands for a text parameter; an expression uses the name alone"},
    Stray{"{", "brackets in expressions are ( ) and [ ]"},
    Stray{"}", "brackets in expressions are ( ) and [ ]"},
    Stray{".", "a point stands inside of numbers, and before an element or output, x.1"},
    Stray{"π", "write pi"},
    Stray{"∞", "write inf"},
    Stray{"²", "a power is written with ^: x^2"},
    Stray{"³", "a power is written with ^: x^3"},
    Stray{"°", "angles are in rad: 30*pi/180"},
    Stray{"\u00A0", "this is a no-break space; write a plain one"},
    Stray{"“", "this is a typographic quote; write \""},
    Stray{"”", "this is a typographic quote; write \""},
    Stray{"√", "a square root is written sqrt(x)"},
};

constexpr std::string_view two_character_symbols[] = {"<=", ">=", "==", "!="};
constexpr std::string_view one_character_symbols = "+-*/^<>()[],";

class Lexer {
 public:
  Lexer(std::string_view text, const TextPlace& place, Report& report) : text_(text), place_(place), report_(report) {}

  Tokens run() {
    tokens_.list.reserve(text_.size() / 2 + 2);
    for (;;) {
      const std::size_t before = at_;
      while (at_ < text_.size() && is_space(text_[at_])) ++at_;
      space_ = at_ > before;
      if (at_ == text_.size()) break;
      next();
    }
    push(Token::Kind::end, text_.size(), 0);
    return std::move(tokens_);
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
  char peek(std::size_t ahead = 0) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }

  Token& push(Token::Kind kind, std::size_t at, std::size_t size) {
    return tokens_.list.emplace_back(Token{kind, text_.substr(at, size), at, size, space_});
  }

  template <typename... Args>
  Finding& error(std::size_t at, std::size_t size, fmt::format_string<Args...> words, Args&&... args) {
    tokens_.failed = true;
    return report_.error(mark_at(text_, place_, at, size), words, std::forward<Args>(args)...).named("expression");
  }

  void next() {
    const char c = peek();
    if (is_digit(c) || (c == '.' && is_digit(peek(1)))) return number();
    if (is_letter(c)) return name();
    symbol();
  }

  void digits() {
    while (is_digit(peek())) ++at_;
  }

  void number() {
    const std::size_t start = at_;
    digits();
    if (peek() == '.' && is_digit(peek(1))) {
      ++at_;
      digits();
    } else if (peek() == '.' && std::string_view("*/^").find(peek(1)) == std::string_view::npos) {
      error(start, at_ + 1 - start, "a number does not end with a point: write {}.0", text_.substr(start, at_ - start));
      ++at_;
    }
    const std::size_t sign = peek(1) == '+' || peek(1) == '-' ? 1 : 0;
    if ((peek() == 'e' || peek() == 'E') && is_digit(peek(1 + sign))) {
      at_ += 1 + sign;
      digits();
    }
    push(Token::Kind::number, start, at_ - start);
    if (is_letter(peek())) glued_product(start);
  }

  // `2x`: reported, and read as 2*x.
  void glued_product(std::size_t start) {
    const std::size_t number_end = at_;
    std::size_t end = at_;
    while (end < text_.size() && (is_letter(text_[end]) || is_digit(text_[end]))) ++end;
    const std::string_view left = text_.substr(start, number_end - start);
    const std::string_view right = text_.substr(number_end, end - number_end);
    Finding& finding = error(start, end - start, "'{}{}' is neither a number nor a name", left, right);
    if (right == "e" || right == "E") {
      finding.hint("an exponent has digits: 1e-3");
    } else {
      finding.hint(fmt::format("a product is written with *: {}*{}", left, right));
      if (std::holds_alternative<Unit>(parse_unit(right))) finding.hint("a number is written without its unit");
    }
    space_ = false;
    push(Token::Kind::symbol, number_end, 0).text = "*";
  }

  // A name with its dotted parts and its slice is one token.
  void name() {
    const std::size_t start = at_;
    word();
    while (peek() == '.' && (is_letter(peek(1)) || is_digit(peek(1)))) {
      ++at_;
      const std::size_t part = at_;
      const bool element = is_digit(peek());
      word();
      if (element) check_element(part);
    }
    if (peek() == ':' && is_digit(text_[at_ - 1]) && is_digit(peek(1))) {
      ++at_;
      const std::size_t part = at_;
      word();
      check_element(part);
    }
    push(Token::Kind::name, start, at_ - start);
  }

  void word() {
    while (is_letter(peek()) || is_digit(peek())) ++at_;
  }

  void check_element(std::size_t start) {
    const std::string_view part = text_.substr(start, at_ - start);
    const bool number = std::all_of(part.begin(), part.end(), is_digit);
    if (!number) {
      error(start, part.size(), "'{}' is neither an element's number nor a name", part);
    } else if (part.find_first_not_of('0') == std::string_view::npos) {
      error(start, part.size(), "elements count from 1");
    } else if (part.size() > 9) {
      error(start, part.size(), "no vector has that many elements");
    } else if (part[0] == '0') {
      error(start, part.size(), "an element's number does not begin with 0");
    }
  }

  void symbol() {
    const std::string_view rest = text_.substr(at_);
    for (const std::string_view two : two_character_symbols) {
      if (rest.starts_with(two)) return known(2);
    }
    for (const Foreign& other : foreign) {
      if (!rest.starts_with(other.written)) continue;
      error(at_, other.written.size(), "'{}' is not known here: {}", other.written, other.words);
      push(Token::Kind::symbol, at_, other.written.size()).text = other.meant;
      at_ += other.written.size();
      return;
    }
    if (one_character_symbols.find(rest[0]) != std::string_view::npos) return known(1);
    for (const Stray& stray : strays) {
      if (!rest.starts_with(stray.written)) continue;
      error(at_, stray.written.size(), "'{}' is not known here: {}", stray.written, stray.words);
      at_ += stray.written.size();
      return;
    }
    const std::size_t size = character_length(text_, at_);
    Finding& finding = error(at_, size, "'{}' has no place in an expression", rest.substr(0, size));
    if (size > 1) finding.hint("names are ASCII letters, digits and _");
    at_ += size;
    // The rest of a word in another alphabet is the same mistake.
    while (at_ < text_.size() && (continues_character(text_[at_]) || static_cast<unsigned char>(text_[at_]) >= 0x80))
      ++at_;
  }

  void known(std::size_t size) {
    push(Token::Kind::symbol, at_, size);
    at_ += size;
  }

  std::string_view text_;
  const TextPlace& place_;
  Report& report_;
  Tokens tokens_;
  std::size_t at_ = 0;
  bool space_ = false;
};

}  // namespace

Tokens tokenize(std::string_view text, const TextPlace& place, Report& report) {
  return Lexer(text, place, report).run();
}

Mark mark_at(std::string_view text, const TextPlace& place, std::size_t at, std::size_t size) {
  const auto characters = [](std::string_view part) { return static_cast<std::uint32_t>(count_characters(part)); };
  if (!place.positions.empty()) {
    Mark mark = place.positions[std::min(at, place.positions.size() - 1)];
    if (at >= place.positions.size()) mark.column += 1;
    mark.length = std::max<std::uint32_t>(1, characters(text.substr(std::min(at, text.size()), size)));
    return mark;
  }
  Mark mark = place.start;
  mark.column += characters(text.substr(0, at));
  mark.length = std::max<std::uint32_t>(1, characters(text.substr(std::min(at, text.size()), size)));
  return mark;
}

std::string_view familiar_function(std::string_view name) {
  constexpr std::pair<std::string_view, std::string_view> pairs[] = {
      {"ln", "log(x), which is natural"},
      {"fabs", "abs(x)"},
      {"fmin", "min(a, b)"},
      {"fmax", "max(a, b)"},
      {"fmod", "mod(a, b)"},
      {"rem", "mod(a, b)"},
      {"if", "where(condition, a, b)"},
      {"ifelse", "where(condition, a, b)"},
      {"select", "where(condition, a, b)"},
      {"sgn", "sign(x)"},
      {"arcsin", "asin(x)"},
      {"arccos", "acos(x)"},
      {"arctan", "atan(x)"},
      {"arctan2", "atan2(y, x)"},
      {"sqr", "x^2"},
      {"square", "x^2"},
      {"saturate", "clamp(x, lower, upper)"},
      {"sat", "clamp(x, lower, upper)"},
      {"limit", "clamp(x, lower, upper)"},
      {"matmul", "mul(A, x)"},
      {"identity", "eye(n)"},
      {"fix", "trunc(x)"},
      {"ceiling", "ceil(x)"},
      {"total", "sum(x)"},
      {"integral", "a block: {type: integrator, in: x}"},
  };
  for (const auto& [other, ours] : pairs) {
    if (other == name) return ours;
  }
  return {};
}

bool asks_for_derivative(std::string_view name) {
  constexpr std::string_view names[] = {"derivative", "der",   "deriv",           "derivate", "derivation",
                                        "diff",       "ddt",   "differentiation", "d/dt",     "differentiate",
                                        "du_dt",      "du/dt", "differentiator",  "d_dt"};
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

}  // namespace plantloop
